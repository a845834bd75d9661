//! Run-length encoding of voxel classes, which the scripts of the viewer decode.

/// Appends classes as runs to some bytes: LEB128 numbers, each the length of a run times the number of classes, plus
/// its class.
pub fn put_runs(classes: impl Iterator<Item = usize>, kinds: usize, bytes: &mut Vec<u8>) {
    let mut run: Option<(usize, u64)> = None;
    let mut put = |(class, length): (usize, u64)| {
        let mut rest = length * kinds as u64 + class as u64;
        while rest >= 0x80 {
            bytes.push(rest as u8 | 0x80);
            rest >>= 7;
        }
        bytes.push(rest as u8);
    };
    for class in classes {
        debug_assert!(class < kinds, "{class} of {kinds}");
        run = match run {
            Some((same, length)) if same == class => Some((same, length + 1)),
            other => {
                other.into_iter().for_each(&mut put);
                Some((class, 1))
            }
        };
    }
    run.into_iter().for_each(put);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_worked_by_hand() {
        let mut bytes = vec![9];
        // Three of class 1: 3·8 + 1. Twenty of class 5: 165 = 37 + 128. One of class 0.
        let classes = [vec![1; 3], vec![5; 20], vec![0]].concat();
        put_runs(classes.into_iter(), 8, &mut bytes);
        assert_eq!(bytes, [9, 25, 165, 1, 8]);
        put_runs(std::iter::empty(), 8, &mut bytes);
        assert_eq!(bytes.len(), 5, "nothing of nothing");
        // Two of class 2 of 3: 3·2 + 2.
        put_runs([2, 2].into_iter(), 3, &mut bytes);
        assert_eq!(bytes[5..], [8]);
    }
}
