mod attractor;
mod collocation;
mod motion;
mod validation;
