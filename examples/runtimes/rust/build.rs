//! Compiles the C library of `mat/kernel`, as its own build does: mat/kernel/backend.py.

use std::path::{Path, PathBuf};

/// Sources that are compiled for any processor; all others once for each number of lanes.
const ONCE: &[&str] = &["dispatch.c", "layouts.c", "processor.c", "tables.c"];
/// Functions that the C library of the system has.
const OF_THE_SYSTEM: &str = "freestanding.c";

/// A package has the sources as files, a checkout as a link, which not every system keeps.
fn sources() -> PathBuf {
    let own = Path::new("kernel");
    if own.is_dir() { own.to_owned() } else { Path::new("../../../mat/kernel").to_owned() }
}

fn compile(files: &[PathBuf], lanes: &str, flag: Option<&str>) {
    let mut build = cc::Build::new();
    build.files(files).std("c11").opt_level(3).debug(false).warnings(false).pic(true).define("LANES", lanes);
    build.define("SKYSHINE_EXPORT", ""); // a library that has the crate in it does not show these functions
    // No contraction and no fast mathematics: every compiler and processor gives the same bytes.
    for each in ["-ffp-contract=off", "-fno-math-errno", "-ffreestanding", "-fno-stack-protector", "-fvisibility=hidden"] {
        build.flag(each);
    }
    if let Some(each) = flag {
        build.flag(each);
    }
    build.compile(&format!("skyshine_{lanes}_{}", files.len()));
}

fn main() {
    let folder = sources();
    println!("cargo::rerun-if-changed={}", folder.display());
    let listed = std::fs::read_dir(&folder).expect("the folder `kernel` of the package, or mat/kernel of the checkout");
    let mut files: Vec<PathBuf> = listed.flatten().map(|entry| entry.path()).collect();
    files.retain(|file| file.extension().is_some_and(|end| end == "c") && !file.ends_with(OF_THE_SYSTEM));
    files.sort();
    let (once, by_lanes): (Vec<_>, Vec<_>) = files.into_iter().partition(|file| ONCE.iter().any(|name| file.ends_with(name)));
    let x86 = std::env::var("CARGO_CFG_TARGET_ARCH").is_ok_and(|machine| machine == "x86_64");
    compile(&once, "4", None);
    compile(&by_lanes, "4", x86.then_some("-msse2"));
    if x86 {
        compile(&by_lanes, "8", Some("-mavx2"));
    }
}
