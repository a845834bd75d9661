#![no_main]

perirobot_fuzz::target!(joints, floor_mib = 8, per_byte = 200);
