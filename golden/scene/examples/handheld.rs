//! Writes a hand-held camera's motion in TUM's form to standard output: five seconds at 100 poses a
//! second, of a person who walks, looks around and does not hold the camera still.
//!
//! ```sh
//! cargo run -p potamoi-scene --example handheld > docs/how-to/handheld.txt
//! ```
//!
//! It is a sum of sines whose periods have no common multiple. A hand trembles at 8 to 12 Hz, and a
//! walk has some two steps a second. No recording went into it.

use glam::{DQuat, DVec3, EulerRot};

/// Amplitude, frequency in Hz, and phase in turns.
type Wave = (f64, f64, f64);

/// Metres along right, down and ahead: the way, steps, and the hand.
const POSITION: [[Wave; 3]; 3] = [
    [(0.35, 0.11, 0.0), (0.020, 0.97, 0.3), (0.0008, 8.3, 0.1)],
    [(0.10, 0.17, 0.2), (0.025, 1.93, 0.0), (0.0010, 9.1, 0.6)],
    [(0.45, 0.09, 0.1), (0.015, 1.87, 0.7), (0.0006, 8.7, 0.4)],
];
/// Degrees about down, right and ahead: looks, sway, and the hand.
const TURN: [[Wave; 3]; 3] = [
    [(18.0, 0.13, 0.0), (2.5, 0.71, 0.4), (0.06, 8.9, 0.2)],
    [(9.0, 0.19, 0.1), (1.8, 1.13, 0.8), (0.08, 9.7, 0.5)],
    [(4.0, 0.23, 0.6), (1.2, 0.93, 0.1), (0.05, 8.5, 0.9)],
];
const POSES: u32 = 500;
const HZ: f64 = 100.0;

fn sum(waves: &[Wave; 3], seconds: f64) -> f64 {
    let wave =
        |(size, hz, phase): &Wave| size * (std::f64::consts::TAU * (hz * seconds + phase)).sin();
    waves.iter().map(wave).sum()
}

fn main() {
    println!(
        "# a made hand-held camera, 1 m = 1 unit: cargo run -p potamoi-scene --example handheld"
    );
    println!("# timestamp tx ty tz qx qy qz qw");
    for k in 0..=POSES {
        let seconds = f64::from(k) / HZ;
        let place = POSITION.map(|waves| sum(&waves, seconds));
        let [yaw, pitch, roll] = TURN.map(|waves| sum(&waves, seconds).to_radians());
        let p = DVec3::from(place);
        let q = DQuat::from_euler(EulerRot::YXZ, yaw, pitch, roll);
        println!(
            "{seconds:.2} {:.4} {:.4} {:.4} {:.5} {:.5} {:.5} {:.5}",
            p.x, p.y, p.z, q.x, q.y, q.z, q.w
        );
    }
}
