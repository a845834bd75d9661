#![no_main]

perirobot_fuzz::target!(ply, floor_mib = 8, per_byte = 200);
