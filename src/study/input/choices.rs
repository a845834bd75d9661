//! The choices of poses of a combination, and their numbers. Equal sensors are placed together: no two of them
//! in the same pose, and which of them stands where makes no difference.

/// How the choices of a combination are numbered.
pub struct Choices(Vec<EqualSensors>);

/// Sensors that follow each other and have the same poses.
#[derive(Clone, Copy)]
struct EqualSensors {
    sensors: usize,
    poses: usize,
}

impl Choices {
    /// The choices of sensors, each given with its poses.
    pub fn from_sensors<'a, S: PartialEq, P: PartialEq + 'a>(
        sensors: impl Iterator<Item = (S, &'a [P])>,
    ) -> Choices {
        let sensors: Vec<_> = sensors.collect();
        let equal = |of_one: &[(S, &[P])]| EqualSensors { sensors: of_one.len(), poses: of_one[0].1.len() };
        Choices(sensors.chunk_by(|a, b| a == b).map(equal).collect())
    }

    /// How many there are; `usize::MAX` stands for more.
    pub fn count(&self) -> usize {
        self.0.iter().map(|equal| subsets(equal.poses, equal.sensors)).fold(1, usize::saturating_mul)
    }

    /// For each sensor the place of its pose in the choice of this number. Choices of the last sensors vary
    /// fastest; poses of equal sensors ascend: 0 1, 0 2, …, 1 2, ….
    pub fn nth(&self, mut number: usize) -> Vec<usize> {
        let mut places = Vec::new();
        for &EqualSensors { sensors, poses } in self.0.iter().rev() {
            let count = subsets(poses, sensors);
            places.extend(nth_subset(number % count, poses, sensors).into_iter().rev());
            number /= count;
        }
        places.reverse();
        places
    }

    /// The number of the choice that has these places, those of equal sensors in any order; `None` where two
    /// equal sensors have the same.
    pub fn number(&self, places: &[usize]) -> Option<usize> {
        let (mut number, mut rest) = (0, places);
        for &EqualSensors { sensors, poses } in &self.0 {
            let mut own;
            (own, rest) = (rest[..sensors].to_vec(), &rest[sensors..]);
            own.sort_unstable();
            if own.windows(2).any(|two| two[0] == two[1]) {
                return None;
            }
            number = number * subsets(poses, sensors) + number_of_subset(&own, poses);
        }
        Some(number)
    }
}

/// How many subsets of `size` numbers there are of `of` numbers; `usize::MAX` stands for more.
fn subsets(of: usize, size: usize) -> usize {
    let Some(rest) = of.checked_sub(size) else { return 0 };
    let mut count: u128 = 1;
    for chosen in 0..size.min(rest) {
        // Exact, since each is a number of subsets; each is at least the one before.
        count = count * (of - chosen) as u128 / (chosen + 1) as u128;
        if count >= usize::MAX as u128 {
            return usize::MAX;
        }
    }
    count as usize
}

/// The subset of this number, ascending, if subsets are in the order of their first numbers, then of their
/// second, and so on.
///
/// Counted from the last one backwards, and each number x as `of − 1 − x`, they are in the combinatorial number
/// system: C(x₁, size) + C(x₂, size − 1) + … with x₁ > x₂ > ….
fn nth_subset(number: usize, of: usize, size: usize) -> Vec<usize> {
    let mut left = subsets(of, size) - 1 - number;
    let next = |size: usize| {
        let (mut low, mut high) = (size - 1, of);
        // The largest whose subsets are not more than what is left.
        while high - low > 1 {
            let middle = low.midpoint(high);
            if subsets(middle, size) <= left { low = middle } else { high = middle }
        }
        left -= subsets(low, size);
        of - 1 - low
    };
    (1..=size).rev().map(next).collect()
}

/// The number of an ascending subset.
fn number_of_subset(subset: &[usize], of: usize) -> usize {
    let sizes = (1..=subset.len()).rev();
    let behind: usize = subset.iter().zip(sizes).map(|(x, size)| subsets(of - 1 - x, size)).sum();
    subsets(of, subset.len()) - 1 - behind
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sensors by name, each with how many poses it has.
    fn choices(sensors: &[(&str, usize)]) -> Choices {
        let poses: Vec<Vec<usize>> = sensors.iter().map(|(_, poses)| (0..*poses).collect()).collect();
        Choices::from_sensors(sensors.iter().map(|(name, _)| *name).zip(poses.iter().map(Vec::as_slice)))
    }

    #[test]
    fn equal_sensors_ascend_and_the_last_vary_fastest() {
        let all = |sensors: &[(&str, usize)]| {
            let choices = choices(sensors);
            (0..choices.count()).map(|number| choices.nth(number)).collect::<Vec<_>>()
        };
        assert_eq!(all(&[("a", 2), ("b", 2)]), [[0, 0], [0, 1], [1, 0], [1, 1]], "of two sensors");
        assert_eq!(all(&[("a", 4), ("a", 4)]), [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]]);
        assert_eq!(
            all(&[("a", 3), ("a", 3), ("b", 2)]),
            [[0, 1, 0], [0, 1, 1], [0, 2, 0], [0, 2, 1], [1, 2, 0], [1, 2, 1]]
        );
        assert_eq!(all(&[("a", 3), ("a", 3), ("a", 3)]), [[0, 1, 2]], "all of them");
        assert_eq!(all(&[("a", 2), ("a", 2), ("a", 2)]), [[0; 3]; 0], "more than there are poses");
    }

    /// Every choice of equal sensors is the one of different sensors whose poses ascend, in the same order.
    #[test]
    fn equal_sensors_have_the_ascending_choices_of_different_ones() {
        for (poses, sensors, more) in [(1, 1, 1), (5, 2, 1), (7, 3, 2), (6, 4, 3), (6, 5, 1)] {
            let (equal, different): (Vec<_>, Vec<_>) =
                ["a", "b", "c", "d", "e"][..sensors].iter().map(|&n| (("a", poses), (n, poses))).unzip();
            let last = ("z", more);
            let [equal, different] = [equal, different].map(|all| choices(&[all, vec![last]].concat()));
            let ascends = |places: &Vec<usize>| places[..sensors].windows(2).all(|two| two[0] < two[1]);
            let expected: Vec<_> =
                (0..different.count()).map(|number| different.nth(number)).filter(ascends).collect();
            let found: Vec<_> = (0..equal.count()).map(|number| equal.nth(number)).collect();
            assert_eq!(found, expected, "{sensors} of {poses}");
            for (number, mut places) in found.into_iter().enumerate() {
                places[..sensors].reverse();
                assert_eq!(equal.number(&places), Some(number), "{places:?}, in any order");
            }
        }
        assert_eq!(choices(&[("a", 3), ("a", 3)]).number(&[1, 1]), None);
    }

    #[test]
    fn many_are_numbered_without_overflow() {
        assert_eq!(
            [subsets(4_000_000, 3), subsets(100, 50), subsets(3, 5)],
            [10_666_658_666_668_000_000, usize::MAX, 0]
        );
        assert_eq!(choices(&[("a", 100); 50]).count(), usize::MAX);
        let choices = choices(&[("a", 2000); 3]);
        assert_eq!(choices.count(), 2000 * 1999 * 1998 / 6);
        assert_eq!([choices.nth(0), choices.nth(choices.count() - 1)], [[0, 1, 2], [1997, 1998, 1999]]);
        for number in (0..choices.count()).step_by(9_999_991) {
            assert_eq!(choices.number(&choices.nth(number)), Some(number));
        }
    }
}
