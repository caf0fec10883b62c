//! Where a field belongs that stands in another section.

use super::Config;

/// A clause with the section of a field that is not of the section where it stands, such as `banks` outside
/// `[gu]`; empty where no section has a field of that name.
pub(super) fn clause(path: &str) -> String {
    let first = path.split('.').next().unwrap_or(path);
    match first {
        "model" | "camera" => {
            return format!("; [{first}] is of a description of a scene, which --scene takes");
        }
        "machines" | "scenes" | "workload" | "vary" | "together" => {
            return format!("; `{first}` is of a plan, which potamoi sweep takes");
        }
        _ => {}
    }
    let key = path.rsplit('.').next().unwrap_or(path);
    let Ok(table) = toml::Table::try_from(Config::paper()) else {
        return String::new();
    };
    let mut found = vec![];
    sections(&table, "", key, &mut found);
    let named: Vec<String> = found.iter().map(|own| format!("[{own}]")).collect();
    match named.is_empty() {
        true => String::new(),
        false => format!("; `{key}` is a field of {}", named.join(" and ")),
    }
}

/// Sections that have a field of this name.
fn sections(table: &toml::Table, path: &str, key: &str, found: &mut Vec<String>) {
    for (name, value) in table {
        if let toml::Value::Table(own) = value {
            let path = match path {
                "" => name.clone(),
                path => format!("{path}.{name}"),
            };
            if own.get(key).is_some_and(|value| !value.is_table()) {
                found.push(path.clone());
            }
            sections(own, &path, key, found);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_field_in_a_wrong_section_is_led_to_its_own() {
        assert_eq!(clause("banks"), "; `banks` is a field of [gu]");
        assert_eq!(
            clause("vu.iterations"),
            "; `iterations` is a field of [vu.exp]"
        );
        assert_eq!(clause("gu.nothing"), "");
        assert!(clause("model.kind").contains("--scene"));
        assert!(clause("vary").contains("potamoi sweep"));
        assert!(
            clause("rit.lanes").ends_with("[gu] and [vu]"),
            "{}",
            clause("rit.lanes")
        );
    }
}
