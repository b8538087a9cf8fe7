use super::attractor::{Effort, follow};
use super::collocation::Bush;

const PAPER: Bush = Bush {
    zeta_k: 3.9, omega_0: 2.0, omega_k: 0.4, b: 1.0, epsilon: 0.1, h1: 0.5, f_0: 0.3, alpha: 0.3, beta: 0.3, epsilon_0: 0.01,
};

#[test]
fn figures() {
    let go = |name: &str, bush: Bush, start| {
        let t = std::time::Instant::now();
        let truth = follow(&bush, start, &Effort::USUAL);
        println!("{name}: {truth:?} {:?}", t.elapsed());
    };
    let q = Bush { f_0: 0.0, alpha: 0.0, beta: 0.0, omega_k: 0.0, epsilon: 1.0, h1: 2.0, zeta_k: 0.0, ..PAPER };
    go("linear -1", Bush { omega_0: 0.1, ..q }, [0.5, 0.0]);
    go("linear h1=20", Bush { h1: 20.0, ..q }, [0.5, 0.0]);
    go("-0.109219", Bush { zeta_k: 2.0, omega_0: 0.03, ..PAPER }, [0.1, 0.0]);
    go("-1.97368", Bush { zeta_k: 8.98, h1: 1.793, omega_0: 1.066, omega_k: 0.3685, b: 3.298, epsilon: 0.3294, f_0: 0.7489, alpha: 0.5981, beta: 0.5635, epsilon_0: 0.04231 }, [0.5542, -0.21]);
    go("-0.10002", Bush { zeta_k: 500.0, epsilon_0: 1e-5, alpha: 0.0, beta: 0.0, h1: 2.0, ..PAPER }, [0.1, 0.0]);
    go("4.3755", Bush { b: -1.0, ..PAPER }, [0.1, 0.0]);
    go("7.5821", Bush { b: -0.1, ..PAPER }, [0.1, 0.0]);
    go("-0.26321", Bush { omega_0: 0.8752, alpha: 0.1045, beta: 0.2019, f_0: 0.8844, b: 1.467, omega_k: -0.1869, epsilon: 0.1055, epsilon_0: 0.01538, zeta_k: 4.2152, h1: 1.00408, ..PAPER }, [0.5394, 1.048]);
    go("chaos .0768", PAPER, [0.1, 0.0]);
    go("-0.2318", Bush { zeta_k: 3.5, ..PAPER }, [0.1, 0.0]);
    go("eps0=1e-6", Bush { zeta_k: 3.5, epsilon_0: 1e-6, ..PAPER }, [0.1, 0.0]);
    go("eps0=1e-9", Bush { zeta_k: 3.5, epsilon_0: 1e-9, ..PAPER }, [0.1, 0.0]);
    go("eps0=1e-9 stick", Bush { zeta_k: 0.3, omega_k: 0.0, f_0: 2.0, epsilon_0: 1e-9, ..PAPER }, [0.9, 0.0]);
    go("eps0=1e-4 stick", Bush { zeta_k: 0.3, omega_k: 0.0, f_0: 2.0, epsilon_0: 1e-4, ..PAPER }, [0.9, 0.0]);
    go("runaway slow", Bush { h1: -0.5, ..Bush {f_0: 0.0, alpha: 0.0, beta: 0.0, ..PAPER} }, [0.1, 0.0]);
}
