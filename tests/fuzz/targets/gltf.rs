#![no_main]

perirobot_fuzz::target!(gltf, floor_mib = 260, per_byte = 500);
