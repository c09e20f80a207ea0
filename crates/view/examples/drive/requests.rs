//! What a client that soaks asks for.

use serde_json::{Value, json};

/// What it looks at.
const LAYERS: [&str; 5] = ["beauty", "normal", "depth", "noise", "albedo"];
/// Requests that are JSON, and cannot be carried out.
const MISUSES: [&str; 8] = [
    r#"{"type":"quit"}"#,
    r#"{"type":"look","eye":[0,1],"target":[0,0,0],"up":[0,1,0]}"#,
    r#"{"type":"render","shell":"rm"}"#,
    r#"{"type":"render","method":{"integrator":"bdpt","k":-1}}"#,
    r#"{"type":"show","exposure":"1","tone_map":"agx"}"#,
    r#"{"type":"open","batch":-1,"path":"a.glb"}"#,
    r#"{"type":"mix","factors":[[1,2]]}"#,
    r#"{"type":"variant","index":"Walnut"}"#,
];

/// A client's next act.
pub enum Act {
    /// A request.
    Ask(Value),
    /// A message that is to be refused.
    Nonsense(String),
    /// One that is no text.
    Bytes(Vec<u8>),
    /// A file that is uploaded and opened.
    Upload(u32),
    /// To save the picture, as this.
    Save(&'static str),
    /// To take no message for a while.
    Nap,
    /// To go without a word, and come back.
    Vanish,
}

/// Numbers that look random (xorshift32).
pub struct Dice(pub u32);

impl Dice {
    /// Below `n`.
    pub fn roll(&mut self, n: u32) -> u32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 17;
        self.0 ^= self.0 << 5;
        self.0 % n
    }

    fn coin<T>(&mut self, heads: T, tails: T) -> T {
        if self.roll(2) == 0 { heads } else { tails }
    }
}

/// A scene's own view, turned about its target.
pub fn turned(view: &Value, angle: f64, input: u32) -> Value {
    let point = |name: &str| [0, 1, 2].map(|i| view[name][i].as_f64().unwrap_or(0.0));
    let (eye, target) = (point("eye"), point("target"));
    let (x, z) = (eye[0] - target[0], eye[2] - target[2]);
    let (sin, cos) = angle.sin_cos();
    let eye = [target[0] + x * cos + z * sin, eye[1], target[2] - x * sin + z * cos];
    json!({ "type": "look", "eye": eye, "target": target, "up": [0, 1, 0], "input": input })
}

fn method(dice: &mut Dice) -> Value {
    let integrator = ["path-naive", "path", "light", "bdpt"][dice.roll(4) as usize];
    let join = ["full", "k-step", "single-step"][dice.roll(3) as usize];
    json!({ "integrator": integrator, "join": join, "k": 1 + dice.roll(9), "pool": dice.coin(true, false) })
}

/// Any act. `view`: the scene's own; `variants`: how many it has.
pub fn any(dice: &mut Dice, view: &Value, variants: u32) -> Act {
    // Seldom: each of these takes long, or the client away.
    match dice.roll(200) {
        0 => return Act::Nap,
        1 => return Act::Vanish,
        2 | 3 => return Act::Save(dice.coin("exr", "png")),
        4 | 5 => return Act::Upload(dice.roll(3)),
        _ => {}
    }
    Act::Ask(match dice.roll(28) {
        0 => json!({ "type": "render", "method": method(dice) }),
        1 => json!({ "type": "split", "right": dice.coin(true, false).then(|| method(dice)) }),
        2 => json!({ "type": "render", "size": [64 + dice.roll(128), 64 + dice.roll(128)] }),
        3 => json!({ "type": "region", "window": dice.coin(None, Some([9, 9, 20, 20])) }),
        4 => json!({ "type": "show", "exposure": f64::from(dice.roll(8)) - 4.0, "tone_map": "aces",
            "layer": LAYERS[dice.roll(5) as usize] }),
        5 => json!({ "type": "restart" }),
        6 => json!({ "type": "take" }),
        7 => json!({ "type": "pick", "x": 0.4, "y": 0.6 }),
        8 => json!({ "type": "render", "max_path_length": dice.roll(9) }),
        9 => json!({ "type": "environment", "strength": f64::from(dice.roll(3)), "rotation": 30 }),
        10 => {
            json!({ "type": "mix", "factors": dice.coin(true, false).then(|| [[1.0, 0.5, f64::from(dice.roll(3))]]) })
        }
        11 => json!({ "type": "pause", "paused": dice.roll(4) == 0 }),
        12 => {
            json!({ "type": "variant", "index": Some(dice.roll(variants + 2)).filter(|index| *index > 0).map(|i| i - 1) })
        }
        13 => return Act::Nonsense(MISUSES[dice.roll(MISUSES.len() as u32) as usize].to_owned()),
        14 => {
            return Act::Nonsense(
                (0..dice.roll(300)).map(|_| char::from(b' ' + dice.roll(95) as u8)).collect(),
            );
        }
        15 => return Act::Bytes((0..dice.roll(300)).map(|_| dice.roll(256) as u8).collect()),
        angle => turned(view, f64::from(angle) / 10.0, angle),
    })
}
