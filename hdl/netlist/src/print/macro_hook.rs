//! Memories that a macro may replace.

use super::Printer;

impl Printer<'_> {
    /// The body, and an instance of a macro with the same ports in its place.
    pub(super) fn with_macro(&mut self) {
        self.text.push_str("\n`ifdef POTAMOI_MACROS\n");
        let ports = self.module.ports.iter().map(|port| port.name.as_str());
        let clock = self.module.is_clocked().then_some("clk");
        let ports: Vec<&str> = clock.into_iter().chain(ports).collect();
        let longest = ports.iter().map(|port| port.len()).max().unwrap_or(0);
        self.line(1, &format!("{}_macro memory_macro (", self.module.name));
        for (i, port) in ports.iter().enumerate() {
            let comma = if i + 1 < ports.len() { "," } else { "" };
            self.line(2, &format!(".{port:<longest$} ({port}){comma}"));
        }
        self.line(1, ");");
        self.text.push_str("`else\n");
        self.localparams();
        self.body();
        self.text.push_str("`endif\n");
    }
}
