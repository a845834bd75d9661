#![no_main]

perirobot_fuzz::target!(urdf, floor_mib = 2048, per_byte = 500);
