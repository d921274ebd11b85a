use super::*;
use crate::test_support::{graph as random_graph, grid_edges};
use proptest::prelude::*;

/// Entries of the factor, by eliminating on a dense pattern.
fn entries_by_elimination(pattern: &Pattern, order: &[u32]) -> u64 {
    let n = pattern.n();
    let mut full = vec![vec![false; n]; n];
    for i in 0..n {
        pattern.row(i).for_each(|slot| full[i][pattern.column(slot)] = true);
    }
    let mut count = 0;
    for (k, &i) in order.iter().enumerate() {
        let later: Vec<_> =
            order[k + 1..].iter().filter(|&&j| full[i as usize][j as usize]).collect();
        count += 1 + later.len() as u64;
        for &&a in &later {
            for &&b in &later {
                full[a as usize][b as usize] = true;
            }
        }
    }
    count
}

fn is_permutation(order: &[u32], n: usize) -> bool {
    let mut sorted = order.to_vec();
    sorted.sort_unstable();
    sorted == (0..n as u32).collect::<Vec<_>>()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn both_orders_are_permutations_and_the_entries_are_counted((n, edges) in random_graph(300)) {
        let pattern = Pattern::new(n, edges);
        for order in [minimum_degree(&pattern).unwrap(), nested_dissection(&pattern)] {
            prop_assert!(is_permutation(&order, n));
            let tree = EliminationTree::new(&pattern, &order);
            let entries = entries_by_elimination(&pattern, &order);
            prop_assert_eq!(tree.entries(), entries);
            let postordered = tree.postordered();
            prop_assert!(is_permutation(&postordered, n));
            prop_assert_eq!(entries_by_elimination(&pattern, &postordered), entries);
        }
    }

    #[test]
    fn separators_leave_no_edge_between_the_sides((n, edges) in random_graph(400)) {
        let graph = Graph::of_pattern(&Pattern::new(n, edges));
        let sides = separate(&graph, &mut Xorshift::new());
        for i in 0..n {
            for j in graph.neighbours(i) {
                prop_assert!(sides[i] == sides[j] || [sides[i], sides[j]].contains(&Side::Separator));
            }
        }
    }
}

#[test]
fn a_grid_is_cut_in_halves_along_a_line() {
    let side = 40;
    let graph = Graph::of_pattern(&Pattern::new(side * side, grid_edges(side)));
    let sides = separate(&graph, &mut Xorshift::new());
    let count = |side| sides.iter().filter(|&&s| s == side).count();
    assert!(count(Side::Separator) <= side + side / 5, "{}", count(Side::Separator));
    assert!(count(Side::Left).min(count(Side::Right)) > side * side * 3 / 10);
}

#[test]
fn dissection_fills_a_large_grid_less_than_minimum_degree() {
    let (side, at_most) = (160, 720_000);
    let pattern = Pattern::new(side * side, grid_edges(side));
    let entries = |order: &[u32]| EliminationTree::new(&pattern, order).entries();
    let dissected = entries(&nested_dissection(&pattern));
    let greedy = entries(&minimum_degree(&pattern).unwrap());
    assert!(dissected < greedy, "{dissected} against {greedy}");
    assert!(dissected <= at_most, "{dissected}");
    assert_eq!(entries(&fill_reducing(&pattern).unwrap()), dissected);
}

#[test]
fn a_path_is_ordered_without_fill() {
    let pattern = Pattern::new(500, (1..500).map(|i| (i - 1, i)));
    let order = fill_reducing(&pattern).unwrap();
    assert_eq!(EliminationTree::new(&pattern, &order).entries(), 999);
}

#[test]
fn a_clique_and_no_nodes_at_all_are_ordered() {
    let clique = Pattern::new(200, (0..200).flat_map(|i| (0..i).map(move |j| (i, j))));
    assert!(is_permutation(&nested_dissection(&clique), 200));
    assert!(fill_reducing(&Pattern::new(0, [])).unwrap().is_empty());
}
