#![no_main]

perirobot_fuzz::target!(collada, floor_mib = 1, per_byte = 500);
