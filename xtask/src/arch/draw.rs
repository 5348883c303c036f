//! `arch --draw`: the block of a crate's rooms as its code has it.

use super::rooms::{self, Plan};

/// The block, users above what they use, or what ties the rooms into circles.
pub(super) fn block(name: &str, plan: &Plan) -> Result<String, Vec<String>> {
    let Some(order) = order(plan) else {
        return Err(rooms::circle_faults(plan).iter().map(|fault| format!("{name}: {fault}")).collect());
    };
    let width = order.iter().map(|place| place.len()).max().unwrap_or_default();
    let mut text = format!("```{}\n", rooms::language(name));
    for user in &order {
        let used: Vec<&str> = order.iter().copied().filter(|used| uses(plan, user, used)).collect();
        let used = if used.is_empty() { "nothing".into() } else { used.join(", ") };
        text += &format!("{user:width$}  ->  {used}\n");
    }
    Ok(text + "```\n")
}

/// The rooms in topological order, each below all that use it, otherwise by name; none where there is a circle.
fn order(plan: &Plan) -> Option<Vec<&str>> {
    let mut open: Vec<&str> = plan.places.iter().map(String::as_str).collect();
    let mut order = Vec::new();
    while !open.is_empty() {
        let free = open.iter().position(|used| !open.iter().any(|user| uses(plan, user, used)))?;
        order.push(open.remove(free));
    }
    Some(order)
}

fn uses(plan: &Plan, user: &str, used: &str) -> bool {
    plan.arrows.keys().any(|(from, to)| from == user && to == used)
}
