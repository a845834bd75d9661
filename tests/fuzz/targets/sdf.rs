#![no_main]

perirobot_fuzz::target!(sdf, floor_mib = 2048, per_byte = 500);
