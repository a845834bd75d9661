#![no_main]

perirobot_fuzz::target!(obj, floor_mib = 1, per_byte = 200);
