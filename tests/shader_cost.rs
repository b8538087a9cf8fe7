//! What a forcing period asks of a GPU: operations, counted in the shader by reflection, and values that a thread holds.
//!
//! `cargo test --test shader_cost -- --nocapture` prints the figures that the roofline estimate in docs/speed.md begins with.

#![cfg(feature = "gpu")]

use naga::{BinaryOperator, Block, Expression, Function, Handle, MathFunction, Module, Statement, TypeInner};
use tribochaos::backend::gpu::shader_source::{Lanes, Shader, Shape};
use tribochaos::dynamics::taylor::{self, COEFFICIENTS, Flow};
use tribochaos::experiment::Scheme;
use tribochaos::lanes::{Real, Ticks};
use tribochaos::parameters::Parameter;
use tribochaos::studies::benchmark;

/// Arithmetic of a piece of a shader, whatever is called included and loops gone through once.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Operations {
    /// A fused multiply-add is two.
    flops: u32,
    /// A fused multiply-add is one; divisions, roots and logarithms are one each.
    instructions: u32,
}

impl Operations {
    fn add(&mut self, other: Self, times: u32) {
        self.flops += times * other.flops;
        self.instructions += times * other.instructions;
    }
}

fn of_expression(module: &Module, expression: &Expression) -> Operations {
    let (flops, instructions) = match expression {
        Expression::Binary { op, .. } => match op {
            BinaryOperator::Add | BinaryOperator::Subtract | BinaryOperator::Multiply | BinaryOperator::Divide => {
                (1, 1)
            }
            _ => (0, 1),
        },
        Expression::Math { fun, .. } => match fun {
            MathFunction::Fma => (2, 1),
            // a modifier of the operand
            MathFunction::Abs => (0, 0),
            MathFunction::Clamp => (0, 2),
            _ => (1, 1),
        },
        Expression::Select { .. } | Expression::As { .. } => (0, 1),
        Expression::CallResult(function) => {
            let called = of_function(module, &module.functions[*function]);
            (called.flops, called.instructions)
        }
        _ => (0, 0),
    };
    Operations { flops, instructions }
}

fn of_function(module: &Module, function: &Function) -> Operations {
    let mut operations = Operations::default();
    let mut emitted = Vec::new();
    emissions(&function.body, &mut emitted);
    for handle in emitted {
        operations.add(of_expression(module, &function.expressions[handle]), 1);
    }
    operations
}

/// The expressions that a block evaluates, calls among them.
fn emissions(block: &Block, emitted: &mut Vec<Handle<Expression>>) {
    for statement in block {
        match statement {
            Statement::Emit(range) => emitted.extend(range.clone()),
            Statement::Call { result, .. } => emitted.extend(*result),
            Statement::Block(block) => emissions(block, emitted),
            Statement::If { accept, reject, .. } => {
                emissions(accept, emitted);
                emissions(reject, emitted);
            }
            Statement::Loop { body, continuing, .. } => {
                emissions(body, emitted);
                emissions(continuing, emitted);
            }
            _ => {}
        }
    }
}

fn of_named(module: &Module, name: &str) -> Operations {
    let mut functions = module.functions.iter();
    let (_, function) = functions
        .find(|(_, function)| function.name.as_deref() == Some(name))
        .unwrap_or_else(|| panic!("the shader has a function {name}"));
    of_function(module, function)
}

/// Numbers in a struct of the shader.
fn numbers(module: &Module, name: &str) -> usize {
    let mut types = module.types.iter();
    let (_, found) = types
        .find(|(_, found)| found.name.as_deref() == Some(name))
        .unwrap_or_else(|| panic!("the shader has a struct {name}"));
    let TypeInner::Struct { span, .. } = found.inner else {
        panic!("{name} is a struct")
    };
    span as usize / 4
}

/// Steps in a forcing period, on the average over every ninth point of the benchmark after ten periods.
fn steps_per_period() -> f64 {
    let points = benchmark::points(9).unwrap();
    let periods = 20;
    let mut steps = 0;
    for p in &points {
        let unit = taylor::unit_of_time(p[Parameter::Omega0]) as f32;
        let flow = Flow::<f32>::of(p, Scheme::Taylor.default_steps_per_period());
        let (mut x, mut y) = (p[Parameter::X0] as f32, p[Parameter::Y0] as f32);
        for period in 0..10 + periods {
            let mut state = flow.start(x, y * unit, Ticks::splat(f32::PERIOD_TICKS));
            while !state.left.all_zero() {
                (_, state) = taylor::step::<f32, COEFFICIENTS, false>(&flow, &state);
                steps += u32::from(period >= 10);
            }
            (x, y) = (state.x, state.w / unit);
        }
    }
    f64::from(steps) / f64::from(periods) / points.len() as f64
}

#[test]
fn a_period_of_taylor_takes_the_operations_that_the_manual_tells() {
    let shape = Shape {
        lanes: Lanes::One,
        modes: None,
    };
    let module = naga::front::wgsl::parse_str(&Shader::of(Scheme::Taylor).source(shape)).unwrap();
    let steps = steps_per_period();
    let motion = of_named(&module, "taylor_step");
    let mut vectors = motion;
    for (name, times) in [("vector_at", 1), ("turning", 1), ("divergence_to", 1)] {
        vectors.add(of_named(&module, name), times);
    }
    let held = ["Flow", "State", "Series"]
        .map(|name| numbers(&module, name))
        .iter()
        .sum::<usize>();
    println!("{steps:.1} steps a period; {held} numbers of a flow, a state and a series held by a thread");
    for (what, operations) in [("motion alone", motion), ("with a vector", vectors)] {
        println!(
            "{what}: {} flops and {} instructions a step, {:.0} and {:.0} a period",
            operations.flops,
            operations.instructions,
            steps * f64::from(operations.flops),
            steps * f64::from(operations.instructions)
        );
    }
    let module = naga::front::wgsl::parse_str(&Shader::of(Scheme::Rk4).source(shape)).unwrap();
    let (rk4, rk4_steps) = (of_named(&module, "rk4_step"), Scheme::Rk4.default_steps_per_period());
    println!(
        "rk4, motion alone: {} flops and {} instructions a step, {} and {} a period",
        rk4.flops,
        rk4.instructions,
        rk4_steps * rk4.flops,
        rk4_steps * rk4.instructions
    );
    assert!((28.0..36.0).contains(&steps), "{steps}");
    // most of it is multiply-add
    for operations in [motion, vectors] {
        assert!(operations.flops > operations.instructions, "{operations:?}");
    }
}
