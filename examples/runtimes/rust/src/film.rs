//! The film of water on a face through a day: the march of schemas/formats/htt-1.md.

/// Of the capacity, by which a film that returns after a day may differ.
const RETURNS: f64 = 1e-9;
/// Marched through at most until it returns.
const DAYS: usize = 30;

/// What a whole film does at one step of the day.
pub struct FilmStep {
    /// Heat loss above that of the dry face [W m^-2] and evaporation [kg m^-2 s^-1], by offset.
    pub loss: Vec<f64>,
    pub evaporation: Vec<f64>,
    /// Sunlight that it absorbs more than the dry face, and that of the dry face [W m^-2].
    pub sunlight: f64,
    pub dry_sunlight: f64,
    /// On the face [kg m^-2 s^-1].
    pub rain: f64,
}

pub struct Film {
    pub steps: Vec<FilmStep>,
    /// Water that stays on the face [kg m^-2].
    pub capacity: f64,
    /// Water at midnight before the day [kg m^-2]; none: the film returns after the day.
    pub before: Option<f64>,
}

/// Share that the film covers at each step of a day, the water before it and at its end over the capacity.
pub struct WetDay {
    pub covered: Vec<f64>,
    pub start: f64,
    pub end: f64,
}

impl Film {
    /// Sunlight that a whole film absorbs more under a change of heat.
    pub fn light(&self, step: usize, absorbed: f64) -> f64 {
        let FilmStep { sunlight, dry_sunlight, .. } = self.steps[step];
        let left = if dry_sunlight > 0.0 { absorbed / dry_sunlight } else { 0.0 };
        sunlight * (1.0 + left).max(0.0).min(1.0)
    }

    /// A day from some water on, under the evaporation of a wholly wet face.
    pub fn march(&self, evaporation: &[f64], start: f64) -> WetDay {
        let scale = 86400.0 / self.steps.len() as f64 / self.capacity;
        let (mut covered, mut end) = (Vec::with_capacity(self.steps.len()), start);
        for (step, loss) in self.steps.iter().zip(evaporation) {
            let gain = ((-loss).max(0.0) + step.rain) * scale;
            let side = root(loss.max(0.0) * scale, end + gain);
            covered.push(side * side);
            end = side * side * side;
        }
        WetDay { covered, start, end }
    }

    /// The file's own day.
    pub fn in_the_open(&self, evaporation: &[f64]) -> WetDay {
        if let Some(before) = self.before {
            return self.march(evaporation, (before / self.capacity).min(1.0));
        }
        let mut day = self.march(evaporation, 0.0);
        for _ in 1..DAYS {
            if day.end - day.start <= RETURNS {
                break;
            }
            day = self.march(evaporation, day.end);
        }
        day
    }

    /// Water before the next march, after one that followed on the file's own day.
    pub fn next_start(&self, open: &WetDay, last: &WetDay) -> f64 {
        match self.before {
            Some(_) => open.start,
            None => (open.start + (last.end - open.end)).max(0.0).min(1.0),
        }
    }
}

/// The root r of r^3 + loss r^2 = water, 0 to 1, by Newton's method from above.
fn root(loss: f64, water: f64) -> f64 {
    if water.is_nan() || water <= 0.0 {
        return 0.0;
    }
    let mut side = water.cbrt();
    if loss > 0.0 {
        side = side.min((water / loss).sqrt());
    }
    for _ in 0..60 {
        let change = (side * side * (side + loss) - water) / (side * (3.0 * side + 2.0 * loss));
        side -= change;
        if change.abs() <= 1e-16 * side {
            break;
        }
    }
    side.min(1.0)
}
