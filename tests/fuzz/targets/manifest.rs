#![no_main]

perirobot_fuzz::target!(manifest, floor_mib = 100, per_byte = 1000);
