// Floats that are whole numbers of up to 2^22 in magnitude, as integers; without bindings.
//
// # Theory
// Beside 1.5 * 2^23 floats are a step of 1 apart, so the sum of it and a whole number is exact, whichever way a device rounds,
// and the number is in its last bits.
//
// # Practice
// WGSL's own conversion cuts what does not fit. Software adapters (Mesa 25) do that one invocation at a time.

const FLOATS_OF_STEP_ONE = 12582912.0;
const FIRST_BITS = 0x4b400000;

fn integer(x: f32) -> i32 {
    return bitcast<i32>(x + FLOATS_OF_STEP_ONE) - FIRST_BITS;
}

fn integer2(x: vec2<f32>) -> vec2<i32> {
    return bitcast<vec2<i32>>(x + FLOATS_OF_STEP_ONE) - FIRST_BITS;
}

fn integer3(x: vec3<f32>) -> vec3<i32> {
    return bitcast<vec3<i32>>(x + FLOATS_OF_STEP_ONE) - FIRST_BITS;
}
