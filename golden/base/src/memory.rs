//! Available memory, checked before a model is loaded.

use std::path::Path;

use rustix::process::{Resource, getrlimit};

/// Bytes that may still be allocated, and the limit that sets them; `None` without a limit.
#[must_use]
pub fn left() -> Option<(u64, &'static str)> {
    let read = |path: &str| std::fs::read_to_string(path).ok();
    let number = |path: &str| read(path)?.trim().parse::<u64>().ok();
    // Pages: all of the address space first.
    let taken = read("/proc/self/statm")
        .and_then(|text| text.split(' ').next()?.parse::<u64>().ok())
        .map(|pages| pages.saturating_mul(rustix::param::page_size() as u64));
    let space = getrlimit(Resource::As).current;
    let space = space.map(|limit| (limit.saturating_sub(taken.unwrap_or(0)), "ulimit -v"));
    let group = number("/sys/fs/cgroup/memory.max").map(|limit| {
        let taken = number("/sys/fs/cgroup/memory.current").unwrap_or(0);
        (
            limit.saturating_sub(taken),
            "the control group's memory.max",
        )
    });
    space.into_iter().chain(group).min()
}

/// The reason why a file's content does not fit in memory. Every model takes at least about as
/// many bytes as its file, since packed files are unpacked.
#[must_use]
pub fn too_large(path: &Path) -> Option<String> {
    let length = std::fs::metadata(path).ok().filter(|m| m.is_file())?.len();
    let (left, limit) = left()?;
    (length / 10 * 9 > left).then(|| {
        format!(
            "its {} MiB do not fit in the {} MiB of memory that {limit} leaves",
            length >> 20,
            left >> 20
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_is_smaller_than_memory_fits() {
        let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml");
        assert_eq!(too_large(&own), None);
        assert_eq!(too_large(Path::new("/nonexistent")), None);
    }
}
