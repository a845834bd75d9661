#![no_main]

perirobot_fuzz::target!(poses, floor_mib = 1, per_byte = 500);
