#![no_main]

perirobot_fuzz::target!(pcd, floor_mib = 512, per_byte = 400);
