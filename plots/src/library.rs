//! The vendored JavaScript.

/// A vendored file.
#[derive(Debug, Clone, Copy)]
pub struct Library {
    /// Name of the package.
    pub name: &'static str,
    /// Its version.
    pub version: &'static str,
    /// Its licence, as an SPDX expression.
    pub licence: &'static str,
    /// SHA-256 of the file.
    pub sha256: &'static str,
    /// The file.
    pub text: &'static str,
    /// The licence's text.
    pub licence_text: &'static str,
}

/// Vega and Vega-Lite, in the order of loading.
pub const LIBRARIES: [Library; 2] = [
    Library {
        name: "vega",
        version: "6.4.0",
        licence: "BSD-3-Clause",
        sha256: "8f6a3587cf8d4f42c7e08120e3eb05d067e746d554e39d2dcf52acc0bd5ba28f",
        text: include_str!("../vendor/vega-6.4.0.min.js"),
        licence_text: include_str!("../vendor/LICENSE-vega"),
    },
    Library {
        name: "vega-lite",
        version: "6.4.3",
        licence: "BSD-3-Clause",
        sha256: "35a9821df838825b05a6a73e9414b58747a1b18321583858ed903c66393a5c7e",
        text: include_str!("../vendor/vega-lite-6.4.3.min.js"),
        licence_text: include_str!("../vendor/LICENSE-vega-lite"),
    },
];

#[cfg(test)]
mod tests {
    use sha2::{Digest as _, Sha256};

    use super::LIBRARIES;

    #[test]
    fn files_have_the_stated_version_licence_and_hash() {
        for own in LIBRARIES {
            let digest = Sha256::digest(own.text.as_bytes());
            let hash: String = digest.iter().map(|byte| format!("{byte:02x}")).collect();
            assert_eq!(hash, own.sha256, "{}", own.name);
            assert!(
                own.text.contains(&format!("\"{}\"", own.version)),
                "{}: the file states another version",
                own.name
            );
            assert_eq!(own.licence, "BSD-3-Clause");
            assert!(own.licence_text.contains("Redistribution and use"));
            assert!(own.licence_text.contains("Neither the name"));
        }
    }

    /// A page holds them between `<script>` and `</script>`.
    #[test]
    fn a_page_can_hold_them() {
        for own in LIBRARIES {
            let lower = own.text.to_lowercase();
            assert!(
                !lower.contains("</script") && !lower.contains("<!--"),
                "{}",
                own.name
            );
        }
    }
}
