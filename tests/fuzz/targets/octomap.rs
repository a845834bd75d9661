#![no_main]

perirobot_fuzz::target!(octomap, floor_mib = 400, per_byte = 100);
