#![no_main]

perirobot_fuzz::target!(npz, floor_mib = 8, per_byte = 5000);
