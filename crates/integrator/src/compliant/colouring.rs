//! Colours for constraints: those of one colour share no particle.

/// An order of the elements, colour by colour, and where each colour ends.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Colouring {
    /// The elements, by their index in the list.
    pub order: Vec<u32>,
    /// Where each colour ends in [`order`](Self::order).
    pub ends: Vec<usize>,
}

impl Colouring {
    /// A single colour that keeps the order of the list, for sweeps that visit one element after
    /// another.
    pub fn list(count: usize) -> Self {
        Self { order: (0..count as u32).collect(), ends: vec![count] }
    }

    /// Gives each element, in the order of the list, the first colour that no neighbour has. Two
    /// elements are neighbours if they share a particle. The result depends on the list alone.
    #[doc(alias = "greedy colouring")]
    pub fn greedy<const K: usize>(particles: usize, elements: &[[u32; K]]) -> Self {
        let mut rest: Vec<u32> = (0..elements.len() as u32).collect();
        let (mut order, mut ends) = (Vec::with_capacity(rest.len()), Vec::new());
        let mut last_colour = vec![0; particles];
        for colour in 1.. {
            if rest.is_empty() {
                break;
            }
            rest.retain(|&element| {
                let members = elements[element as usize];
                let is_free = members.iter().all(|&i| last_colour[i as usize] != colour);
                if is_free {
                    members.iter().for_each(|&i| last_colour[i as usize] = colour);
                    order.push(element);
                }
                !is_free
            });
            ends.push(order.len());
        }
        Self { order, ends }
    }

    /// The index ranges of the colours; `ends` holds where each colour ends.
    pub fn ranges(ends: &[usize]) -> impl Iterator<Item = std::ops::Range<usize>> + '_ {
        let starts = std::iter::once(0).chain(ends.iter().copied());
        starts.zip(ends).map(|(start, &end)| start..end)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The edges of a path alternate; a triangle needs three colours.
    #[test]
    fn neighbours_never_share_a_colour_and_the_first_free_one_is_taken() {
        let path = [[0, 1], [1, 2], [2, 3], [3, 4]];
        let found = Colouring::greedy(5, &path);
        assert_eq!(found, Colouring { order: vec![0, 2, 1, 3], ends: vec![2, 4] });
        let triangle = [[0, 1], [1, 2], [2, 0], [3, 4]];
        let found = Colouring::greedy(5, &triangle);
        assert_eq!(found, Colouring { order: vec![0, 3, 1, 2], ends: vec![2, 3, 4] });
        assert_eq!(Colouring::greedy::<2>(5, &[]).ends, [0; 0]);
        let ranges: Vec<_> = Colouring::ranges(&found.ends).collect();
        assert_eq!(ranges, [0..2, 2..3, 3..4]);
    }

    /// A member that is named twice, as a fourth beside three particles, takes no second colour.
    #[test]
    fn an_element_is_no_neighbour_of_itself() {
        assert_eq!(Colouring::greedy(3, &[[0, 1, 2, 0]]).ends, [1]);
    }
}
