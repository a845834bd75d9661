#![no_main]

perirobot_fuzz::target!(rays, floor_mib = 1, per_byte = 200);
