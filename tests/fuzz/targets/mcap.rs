#![no_main]

perirobot_fuzz::target!(mcap, floor_mib = 1024, per_byte = 400);
