//! What users write and what strangers send: it is read, or refused by file, key and value.

#[path = "../common/mod.rs"]
mod common;

mod bad_folders;
mod bad_input;
mod bad_meshes;
mod bad_numbers;
mod bad_places;
mod bad_sensors;
mod bad_urdf;
mod carried;
mod check;
mod corpus;
mod field;
mod field_cases;
mod first_hour;
mod generated_meshes;
mod joint_limits;
mod own_catalogue;
mod people;
mod regions;
mod robots;
mod schemas;
mod snapshots;
mod step;
#[cfg(target_os = "linux")]
mod strangers;
mod templates;
mod warnings;
mod world_files;
#[cfg(unix)]
mod xacro;
