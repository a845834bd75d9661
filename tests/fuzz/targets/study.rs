#![no_main]

perirobot_fuzz::target!(study, floor_mib = 2048, per_byte = 1000);
