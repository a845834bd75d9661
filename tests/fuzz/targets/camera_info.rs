#![no_main]

perirobot_fuzz::target!(camera_info, floor_mib = 1, per_byte = 500);
