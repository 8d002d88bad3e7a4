//! One axis of an array.

use crate::layouts::{rules_of, HARMONICS, LAST_CODE, ZONES};

pub type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

/// Neighbouring nodes of a value and the weight of the upper one.
pub struct Place {
    pub lower: usize,
    pub upper: usize,
    pub weight: f64,
}

pub struct Axis {
    pub name: String,
    pub nodes: Vec<f64>,
    pub rule: String,
    pub period: f64,
    pub clamps: bool,
    /// Of source elevations: no light of the source is left there.
    pub dark_below: Option<f64>,
}

impl Axis {
    /// Refuse a rule or nodes that are not as the format has them.
    pub fn check(&self) -> Result<()> {
        let (rules, period) = rules_of(&self.name);
        let (first, last) = (self.nodes[0], self.nodes[self.nodes.len() - 1]);
        let (folded, periodic) = (self.rule == "linear_folded", self.rule == "linear_periodic");
        if !rules.contains(&self.rule.as_str()) {
            return Err(format!("the axis '{}' has interpolation '{}'; allowed: {}", self.name, self.rule, rules.join(" or ")).into());
        }
        if let Some(dark) = self.dark_below.filter(|dark| self.name == "source_elevation" && !(-90.0..=0.0).contains(dark)) {
            return Err(format!("the axis '{}' has dark_below {dark}; allowed: -90 to 0", self.name).into());
        }
        if self.period != period {
            return Err(format!("the axis '{}' has period {}; allowed: {period}", self.name, self.period).into());
        }
        if !self.nodes.iter().all(|node| node.is_finite()) || self.nodes.windows(2).any(|pair| pair[1] <= pair[0]) {
            return Err(format!("the axis '{}' has nodes that are not ascending numbers", self.name).into());
        }
        let outside = (folded && (first < 0.0 || last > period / 2.0)) || (periodic && last >= first + period);
        if outside || (period > 0.0 && last > first + period) {
            return Err(format!("the axis '{}' has nodes beyond its period", self.name).into());
        }
        let codes = match self.name.as_str() {
            "harmonic" => Some((HARMONICS, [6, 11])),
            "zonal_harmonic" => Some((ZONES, [3, 4])),
            _ => None,
        };
        if let Some((codes, counts)) = codes {
            let known = counts.contains(&self.nodes.len()) && codes.starts_with(&self.nodes);
            return if known { Ok(()) } else { Err(format!("the axis '{}' has codes that are not those of the format", self.name).into()) };
        }
        if self.rule == "exact" && (first < 1.0 || last > LAST_CODE) {
            return Err(format!("the axis '{}' has codes beyond 1 to {LAST_CODE}", self.name).into());
        }
        Ok(())
    }

    pub fn locate(&self, given: f64) -> Result<Place> {
        if !given.is_finite() {
            return Err(format!("{}: found {given}; allowed: finite numbers", self.name).into());
        }
        let (mut value, first, count) = (given, self.nodes[0], self.nodes.len());
        let mut last = self.nodes[count - 1];
        match self.rule.as_str() {
            "exact" => {
                let at = self.nodes.iter().position(|node| *node == value);
                let at = at.ok_or_else(|| format!("{}: found {value}; allowed: a code of the file", self.name))?;
                return Ok(Place { lower: at, upper: at, weight: 0.0 });
            }
            "linear_periodic" => {
                last = first + self.period;
                value = first + (value - first).rem_euclid(self.period);
            }
            "linear" if self.period > 0.0 => value -= self.period * ((value - first) / self.period).floor(),
            "linear_folded" => value = ((value + self.period / 2.0).rem_euclid(self.period) - self.period / 2.0).abs(),
            _ => {}
        }
        if !self.clamps && !(first..=last).contains(&value) {
            return Err(format!("{}: found {value}; allowed: {first} to {last}", self.name).into());
        }
        value = value.clamp(first, last);
        let closed = self.rule == "linear_periodic"; // after the last node comes the first again
        let cells = if closed { count } else { count - 1 };
        let below = self.nodes.partition_point(|node| *node <= value);
        let lower = below.saturating_sub(1).min(cells.saturating_sub(1));
        let upper = if cells == 0 { lower } else { (lower + 1) % count };
        let end = if lower + 1 < count { self.nodes[lower + 1] } else { last };
        let weight = if end > self.nodes[lower] { (value - self.nodes[lower]) / (end - self.nodes[lower]) } else { 0.0 };
        Ok(Place { lower, upper, weight })
    }
}
