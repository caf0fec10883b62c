//! Prints the gathering unit of the paper's configuration into a folder.
use potamoi_formats::config::Config;
use potamoi_hdl::{gu, ir};
fn main() {
    let dir = std::env::args().nth(1).unwrap_or_else(|| "out".into());
    let text = std::env::args()
        .nth(2)
        .map(|p| std::fs::read_to_string(p).unwrap())
        .unwrap_or_default();
    let config = match Config::from_toml(&text, "x") {
        Ok(c) => c,
        Err(e) => {
            eprintln!("{e}");
            return;
        }
    };
    for unit in [
        gu::gathering_unit(&config),
        potamoi_hdl::vu::vector_unit(&config),
    ] {
        match unit {
            Ok(m) => {
                std::fs::create_dir_all(&dir).unwrap();
                for (name, text) in ir::verilog(&m, &ir::Header::default()) {
                    std::fs::write(format!("{dir}/{name}"), text).unwrap();
                }
            }
            Err(e) => eprintln!("{e}"),
        }
    }
}
