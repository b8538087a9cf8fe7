// The state of an instance as a pass sees it. Twin: src/dynamics/adaptive/orbit.rs.

fn begin(orbit: ptr<function, Orbit>, system: System) -> Start {
    let speed = fma(system.rubbing.zeta_k, (*orbit).sine, system.rubbing.omega_k);
    let heat = Heat((*orbit).heat_pressure, (*orbit).heat_falloff);
    let piece = rubbing_piece(system.rubbing, (*orbit).piece);
    return start_new(system.rubbing, piece, (*orbit).x, (*orbit).v, speed, (*orbit).fit, heat, (*orbit).contact);
}
