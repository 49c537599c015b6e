//! Lists of entities that are kept in order.

use bevy::ecs::entity::Entity;

/// Takes entities out of a list and puts others in. All are in ascending order; of one that is there several times, all
/// are taken out. What lies between the changes is copied as it is. `buffer` is kept for its memory.
pub(super) fn amend(
    list: &mut Vec<Entity>,
    removed: impl Iterator<Item = Entity>,
    added: impl Iterator<Item = Entity>,
    buffer: &mut Vec<Entity>,
) {
    let (mut removed, mut added) = (removed.peekable(), added.peekable());
    if removed.peek().is_none() && added.peek().is_none() {
        return;
    }
    buffer.clear();
    let mut rest = &list[..];
    loop {
        let next = match (removed.peek(), added.peek()) {
            (Some(&removed), Some(&added)) => removed.min(added),
            (Some(&next), None) | (None, Some(&next)) => next,
            (None, None) => break,
        };
        let (before, from) = rest.split_at(first_not_below(rest, next));
        buffer.extend_from_slice(before);
        rest = from;
        if removed.next_if_eq(&next).is_some() {
            rest = &rest[rest.iter().take_while(|&&entity| entity == next).count()..];
        }
        while let Some(entity) = added.next_if_eq(&next) {
            buffer.push(entity);
        }
    }
    buffer.extend_from_slice(rest);
    std::mem::swap(list, buffer);
}

/// How many come before `entity`: found in steps that double (Bentley and Yao 1976), for it is mostly near the
/// beginning.
fn first_not_below(list: &[Entity], entity: Entity) -> usize {
    let mut end = 1;
    while end < list.len() && list[end - 1] < entity {
        end *= 2;
    }
    let start = end / 2;
    let end = end.min(list.len());
    start + list[start..end].partition_point(|&other| other < entity)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entities(indices: &[u32]) -> Vec<Entity> {
        let mut entities: Vec<_> = indices
            .iter()
            .map(|&index| Entity::from_raw_u32(index).expect("an index"))
            .collect();
        entities.sort_unstable();
        entities
    }

    fn amended(list: &[u32], removed: &[u32], added: &[u32]) -> Vec<Entity> {
        let mut list = entities(list);
        let (removed, added) = (entities(removed), entities(added));
        amend(&mut list, removed.into_iter(), added.into_iter(), &mut Vec::new());
        list
    }

    #[test]
    fn what_is_removed_is_gone_and_what_is_added_is_in_its_place() {
        assert_eq!(amended(&[1, 3, 5, 7], &[3], &[4, 9, 0]), entities(&[0, 1, 4, 5, 7, 9]));
    }

    #[test]
    fn an_entity_that_is_there_several_times_goes_as_a_whole() {
        assert_eq!(amended(&[1, 3, 3, 3, 5], &[3], &[]), entities(&[1, 5]));
    }

    #[test]
    fn an_entity_that_is_removed_and_added_is_there_as_often_as_it_was_added() {
        assert_eq!(amended(&[1, 3, 3], &[3], &[3]), entities(&[1, 3]));
    }

    #[test]
    fn an_empty_list_takes_what_is_added() {
        assert_eq!(amended(&[], &[2], &[1, 1]), entities(&[1, 1]));
    }

    #[test]
    fn long_lists_stay_in_order() {
        let all: Vec<u32> = (0..1000).collect();
        let (odd, rest): (Vec<u32>, Vec<u32>) = all.iter().partition(|&&index| index % 7 == 1);
        assert_eq!(amended(&all, &odd, &[]), entities(&rest));
        assert_eq!(amended(&rest, &[], &odd), entities(&all));
    }
}
