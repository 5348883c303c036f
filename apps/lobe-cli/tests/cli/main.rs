//! The command `lobe` as its users meet it: files and arguments in, files, stdout, stderr and exit code out.

#![allow(clippy::unwrap_used, reason = "a helper of a test that cannot do its work has found a failure")]

mod background;
mod bad_input;
mod bad_motion;
mod bad_usage;
mod bake;
mod bake_killed;
#[cfg(unix)]
mod bake_stopped;
mod batch;
mod compare;
mod conventions;
mod double_sided;
mod encodings;
mod engines;
mod env;
mod environment_mode;
#[cfg(target_os = "linux")]
mod full_disk;
mod guide;
mod harness;
mod kept_bake;
mod lamp;
mod light;
mod lightmaps;
mod manual;
mod maps;
mod materials;
mod memory;
mod moving;
mod moving_files;
mod named_light;
mod normal_maps;
mod project;
mod render;
mod ringing;
mod scene_options;
mod sh;
mod sh_arithmetic;
mod sh_log_exp;
mod shaders;
mod shadow_options;
mod sharing;
mod skinned_spheres;
#[cfg(unix)]
mod stopped;
mod streams;
mod suns_and_photographs;
mod transfer;
