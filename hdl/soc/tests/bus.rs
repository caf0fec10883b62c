//! A manager of AXI4-Lite in the interpreter, which checks the handshakes as it goes.

use potamoi_formats::config::Config;
use potamoi_netlist::Interpreter;
use potamoi_soc::npu::npu_ext;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// Clocks after which a transfer counts as hanging.
const PATIENCE: u32 = 200;

pub(crate) const OKAY: u64 = 0;
pub(crate) const SLVERR: u64 = 2;

/// The top with a manager at its bus.
pub(crate) struct Top {
    pub(crate) run: Interpreter,
    pub(crate) random: Pcg64Mcg,
    /// Percentage of clocks in which the manager waits.
    pub(crate) pauses: u32,
    /// Responses that are offered, and must not move until they are taken: B and R.
    offered: [Option<[u64; 2]>; 2],
}

/// A write.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Write {
    pub(crate) address: u64,
    pub(crate) data: u64,
    pub(crate) strobe: u64,
}

impl Top {
    pub(crate) fn new(config: &Config, seed: u64, pauses: u32) -> Self {
        let module = npu_ext(config).unwrap_or_else(|e| panic!("{e}"));
        let mut top = Self {
            run: Interpreter::new(&module, seed),
            random: Pcg64Mcg::seed_from_u64(seed),
            pauses,
            offered: [None; 2],
        };
        for port in module.ports().iter().filter(|port| !port.output) {
            let found = top.run.port(&port.name).unwrap();
            let words = vec![0; port.ty.width.div_ceil(32) as usize];
            top.run.set_words(found, &words).unwrap();
        }
        top.reset();
        top
    }

    pub(crate) fn reset(&mut self) {
        self.set("rst_n", 0);
        self.offered = [None; 2];
        self.run.clock().unwrap();
        for ready in ["s_axil_awready", "s_axil_wready", "s_axil_arready"] {
            assert_eq!(self.get(ready), 0, "{ready} in reset");
        }
        self.run.clock().unwrap();
        self.set("rst_n", 1);
    }

    pub(crate) fn set(&mut self, name: &str, value: u64) {
        let port = self.run.port(name).unwrap();
        self.run.set_u64(port, value).unwrap();
    }

    pub(crate) fn get(&mut self, name: &str) -> u64 {
        let port = self.run.port(name).unwrap();
        self.run.eval().unwrap();
        self.run.get_u64(port).unwrap()
    }

    fn willing(&mut self) -> bool {
        self.random.random_range(0..100) >= self.pauses
    }

    /// A clock. Responses that are not taken must stay as they are.
    pub(crate) fn clock(&mut self) {
        for (channel, [valid, ready, first, second]) in [
            [
                "s_axil_bvalid",
                "s_axil_bready",
                "s_axil_bresp",
                "s_axil_bresp",
            ],
            [
                "s_axil_rvalid",
                "s_axil_rready",
                "s_axil_rresp",
                "s_axil_rdata",
            ],
        ]
        .into_iter()
        .enumerate()
        {
            let shown = (self.get(valid) == 1).then(|| [self.get(first), self.get(second)]);
            if let Some(before) = self.offered[channel] {
                assert_eq!(shown, Some(before), "{valid} or its payload moved");
            }
            self.offered[channel] = shown.filter(|_| self.get(ready) == 0);
        }
        self.run.clock().unwrap();
    }

    /// Sends some of the channels of address, data and read, each after pauses of its own, and takes
    /// the responses after further ones.
    fn transfer(
        &mut self,
        write: Option<Write>,
        read: Option<u64>,
    ) -> (Option<u64>, Option<[u64; 2]>) {
        let channels = [
            ("s_axil_awvalid", "s_axil_awready", write.is_some()),
            ("s_axil_wvalid", "s_axil_wready", write.is_some()),
            ("s_axil_arvalid", "s_axil_arready", read.is_some()),
        ];
        let mut sent = channels.map(|(.., sends)| !sends);
        let mut shown = [false; 3];
        let (mut answer, mut data) = (None, None);
        for _ in 0..PATIENCE {
            for (at, (valid, ..)) in channels.iter().enumerate() {
                shown[at] = !sent[at] && (shown[at] || self.willing());
                self.set(valid, u64::from(shown[at]));
            }
            // The payload of a channel without valid is another one, which must not be taken.
            let other = self.random.random_range(0..1u64 << 32);
            let of = write.unwrap_or(Write {
                address: 0,
                data: 0,
                strobe: 0,
            });
            self.set(
                "s_axil_awaddr",
                if shown[0] { of.address } else { other & 0xfff },
            );
            self.set("s_axil_wdata", if shown[1] { of.data } else { other });
            self.set(
                "s_axil_wstrb",
                if shown[1] { of.strobe } else { other & 0xf },
            );
            self.set(
                "s_axil_araddr",
                if shown[2] {
                    read.unwrap_or(0)
                } else {
                    other & 0xfff
                },
            );
            let takes = [self.willing(), self.willing()].map(u64::from);
            self.set("s_axil_bready", takes[0]);
            self.set("s_axil_rready", takes[1]);
            // No ready depends on a valid, and no valid on a ready: they are as they would be.
            let accepted = channels.map(|(_, ready, _)| self.get(ready) == 1);
            if self.get("s_axil_bvalid") == 1 && takes[0] == 1 {
                assert!(
                    sent[0] && sent[1] && answer.is_none(),
                    "a response to no write"
                );
                answer = Some(self.get("s_axil_bresp"));
            }
            if self.get("s_axil_rvalid") == 1 && takes[1] == 1 {
                assert!(sent[2] && data.is_none(), "data of no read");
                data = Some([self.get("s_axil_rresp"), self.get("s_axil_rdata")]);
            }
            self.clock();
            for at in 0..3 {
                sent[at] |= shown[at] && accepted[at];
            }
            if sent == [true; 3]
                && answer.is_some() == write.is_some()
                && data.is_some() == read.is_some()
            {
                for port in ["awvalid", "wvalid", "arvalid", "bready", "rready"] {
                    self.set(&format!("s_axil_{port}"), 0);
                }
                return (answer, data);
            }
        }
        panic!("{write:?}, read {read:?}: no response; sent {sent:?}, {answer:?}, {data:?}");
    }

    /// Writes, and returns the response.
    pub(crate) fn write(&mut self, write: Write) -> u64 {
        self.transfer(Some(write), None).0.unwrap()
    }

    /// Reads, and returns response and data.
    pub(crate) fn read(&mut self, address: u64) -> [u64; 2] {
        self.transfer(None, Some(address)).1.unwrap()
    }

    /// Writes and reads at the same time.
    pub(crate) fn both(&mut self, write: Write, address: u64) -> (u64, [u64; 2]) {
        let (answer, data) = self.transfer(Some(write), Some(address));
        (answer.unwrap(), data.unwrap())
    }
}
