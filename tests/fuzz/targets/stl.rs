#![no_main]

perirobot_fuzz::target!(stl, floor_mib = 1, per_byte = 200);
