// The proof that a kernel ran to its end: what every kernel shares but its arithmetic. It binds `done`.
//
// # Theory
// A driver may end a loop early and say nothing (src/march/backend/gpu/loop_bounds.rs). So after each loop its
// kernel asks of what the loop left behind whether it ended by its own condition. A compiler knows that it
// did, and would drop the question; it cannot where `opaque` numbers decide.

// Whether some loop of this invocation was ended before its own condition held.
var<private> was_cut: bool;
// Invocations of the workgroup of which no loop was.
var<workgroup> whole: atomic<u32>;

// The same number, which no compiler can tell.
fn opaque(number: u32) -> u32 {
    return number + part.zero;
}

// Follows each loop, with the condition by which it ends.
fn loop_ended(by_its_own_condition: bool) {
    was_cut = was_cut || !by_its_own_condition;
}

// The last statement of each kernel, for all invocations of a workgroup together: adds the workgroup to those
// that came to their end, and its invocations whose loops did.
fn report(kernel: u32, local: u32) {
    if !was_cut {
        atomicAdd(&whole, 1u);
    }
    workgroupBarrier();
    if local == 0u {
        atomicAdd(&done[kernel], 1u);
        atomicAdd(&done[KERNELS + kernel], atomicLoad(&whole));
    }
}
