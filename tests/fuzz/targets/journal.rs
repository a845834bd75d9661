#![no_main]

perirobot_fuzz::target!(journal, floor_mib = 16, per_byte = 200);
