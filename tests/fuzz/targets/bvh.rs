#![no_main]

perirobot_fuzz::target!(bvh, floor_mib = 8, per_byte = 500);
