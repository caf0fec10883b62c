//! What a configuration gives an SoC: the top that joins the units, its registers, and all files.
//!
//! [`npu`] joins the gathering unit and the vector unit with registers on a bus. [`emit`] prints the
//! units and the top as Verilog, and [`package`] describes those files to the tools that take them.
//!
//! ```
//! use potamoi_formats::config::Config;
//!
//! let config = Config::default();
//! let files = potamoi_soc::emit::emit(&config, "", "potamoi emit")?;
//! assert!(files.keys().any(|path| path.ends_with("reducer.v")));
//! # Ok::<(), potamoi_netlist::IrErrors>(())
//! ```

pub mod emit;
pub mod npu;
pub mod package;
