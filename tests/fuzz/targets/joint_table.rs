#![no_main]

perirobot_fuzz::target!(joint_table, floor_mib = 8, per_byte = 500);
