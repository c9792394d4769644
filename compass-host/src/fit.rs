//! Constants that are fitted to localizations of known poses.
//!
//! The probability of a pose is a logistic function of its lead ([`compass_core::Fix::probability`]). It is fitted by maximum
//! likelihood, to frames on their own plan and on plans of other buildings, and tried on each building by a fit to the others.

use nalgebra::{Matrix2, Vector2};

/// Steps of Newton's method; ten suffice.
const MAX_STEPS: usize = 100;
/// Log likelihood, negated, below which nothing is left to chance.
const CERTAIN: f64 = 1e-6;
/// Change of the log likelihood that ends them.
const CONVERGED: f64 = 1e-10;

/// A localization whose true pose is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Answer {
    /// Number of the building that the frame shows.
    pub building: usize,
    /// Lead over the second best explanation, nats.
    pub lead: f64,
    /// Whether the pose is right; never on the plan of another building.
    pub is_right: bool,
    /// Whether the plan is that of another building.
    pub is_foreign: bool,
}

/// Log odds that a pose is right, as a function of its lead.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Logistic {
    /// Log odds without a lead, and the factor of the lead in 1/nat.
    pub weights: Vector2<f64>,
    /// Covariance of the two.
    pub covariance: Matrix2<f64>,
}

impl Logistic {
    /// The maximum-likelihood fit; `None` if right and wrong answers can be told apart without error, or there is but one kind.
    #[must_use]
    pub fn fit(answers: &[Answer]) -> Option<Self> {
        let mut weights = Vector2::zeros();
        let mut likelihood = f64::NEG_INFINITY;
        for _ in 0..MAX_STEPS {
            let fitted = Self { weights, covariance: Matrix2::zeros() };
            let now = fitted.log_likelihood(answers);
            let (gradient, information) = fitted.slopes(answers);
            let covariance = information.try_inverse()?;
            if (now - likelihood).abs() < CONVERGED {
                // Without an error the weights have no bound.
                let is_bounded = now < -CERTAIN && weights.iter().all(|weight| weight.is_finite());
                return is_bounded.then_some(Self { weights, covariance });
            }
            (likelihood, weights) = (now, weights + covariance * gradient);
        }
        None
    }

    /// Probability of an answer.
    #[must_use]
    pub fn probability(&self, answer: &Answer) -> f64 {
        1.0 / (1.0 + (-self.weights.dot(&features(answer))).exp())
    }

    /// Logarithm of the likelihood of answers.
    #[must_use]
    pub fn log_likelihood(&self, answers: &[Answer]) -> f64 {
        answers.iter().map(|answer| log_likelihood(answer, self.probability(answer))).sum()
    }

    /// Slope of the log likelihood, and its information matrix.
    fn slopes(&self, answers: &[Answer]) -> (Vector2<f64>, Matrix2<f64>) {
        answers.iter().fold((Vector2::zeros(), Matrix2::zeros()), |(slope, information), answer| {
            let (probability, x) = (self.probability(answer), features(answer));
            let off = f64::from(u8::from(answer.is_right)) - probability;
            (slope + x * off, information + x * x.transpose() * (probability * (1.0 - probability)))
        })
    }
}

fn features(answer: &Answer) -> Vector2<f64> {
    Vector2::new(1.0, answer.lead)
}

/// Logarithm of the probability of what came true.
#[must_use]
pub fn log_likelihood(answer: &Answer, probability: f64) -> f64 {
    let came_true = if answer.is_right { probability } else { 1.0 - probability };
    came_true.max(f64::MIN_POSITIVE).ln()
}

/// The probability of each answer by a fit to the other buildings; `None` if one of the fits fails.
#[must_use]
pub fn cross_validated(answers: &[Answer]) -> Option<Vec<f64>> {
    let buildings = answers.iter().map(|answer| answer.building).max().map_or(0, |last| last + 1);
    let fits: Vec<Option<Logistic>> = (0..buildings)
        .map(|left_out| {
            let others = answers.iter().filter(|answer| answer.building != left_out);
            Logistic::fit(&others.copied().collect::<Vec<_>>())
        })
        .collect();
    answers.iter().map(|answer| Some(fits[answer.building]?.probability(answer))).collect()
}

/// What is said from a probability on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Said {
    /// Answers on the right plan, said and right.
    pub right: usize,
    /// Answers on the right plan, said and wrong.
    pub wrong: usize,
    /// Answers on plans of other buildings.
    pub foreign: usize,
}

impl Said {
    /// Counts what has at least this probability.
    #[must_use]
    pub fn of(answers: &[Answer], probabilities: &[f64], at_least: f64) -> Self {
        let said = answers.iter().zip(probabilities).filter(|(_, probability)| **probability >= at_least);
        said.fold(Self::default(), |mut said, (answer, _)| {
            let count = match answer {
                Answer { is_foreign: true, .. } => &mut said.foreign,
                Answer { is_right: true, .. } => &mut said.right,
                _ => &mut said.wrong,
            };
            *count += 1;
            said
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt as _, SeedableRng as _};

    /// Answers that follow a logistic function exactly, of four buildings.
    fn answers(constant: f64, factor: f64) -> Vec<Answer> {
        let mut random = rand_xoshiro::Xoshiro256PlusPlus::seed_from_u64(9);
        let mut answer = |number: usize| {
            let lead = random.random_range(0.0..300.0);
            let probability = 1.0 / (1.0 + (-constant - factor * lead).exp());
            let is_right = random.random::<f64>() < probability;
            Answer { building: number % 4, lead, is_right, is_foreign: !is_right && number.is_multiple_of(3) }
        };
        (0..4000).map(&mut answer).collect()
    }

    #[test]
    fn the_constants_that_made_the_answers_are_found() {
        let answers = answers(-4.0, 0.05);
        let fitted = Logistic::fit(&answers).unwrap();
        for (found, (wanted, variance)) in
            fitted.weights.iter().zip([-4.0, 0.05].into_iter().zip(fitted.covariance.diagonal().iter()))
        {
            assert!((found - wanted).abs() < 3.0 * variance.sqrt(), "{fitted:?}");
        }
        let better = fitted.log_likelihood(&answers);
        for step in [Vector2::new(0.05, 0.0), Vector2::new(0.0, 0.001)] {
            for weights in [fitted.weights + step, fitted.weights - step] {
                assert!(Logistic { weights, ..fitted }.log_likelihood(&answers) < better);
            }
        }
    }

    #[test]
    fn what_is_said_is_as_often_right_as_it_says() {
        let answers = answers(-3.0, 0.04);
        let probabilities = cross_validated(&answers).unwrap();
        let mean: f64 = probabilities.iter().sum::<f64>() / answers.len() as f64;
        let right = answers.iter().filter(|answer| answer.is_right).count() as f64 / answers.len() as f64;
        assert!((mean - right).abs() < 0.01, "{mean} {right}");
        let said = Said::of(&answers, &probabilities, 0.8);
        assert!(said.right * 100 > (said.right + said.wrong + said.foreign) * 85, "{said:?}");
        let all = Said::of(&answers, &probabilities, 0.0);
        assert_eq!(all.right + all.wrong + all.foreign, answers.len());
    }

    #[test]
    fn what_can_be_told_apart_has_no_fit() {
        let answer = |lead, is_right| Answer { building: 0, lead, is_right, is_foreign: false };
        assert_eq!(Logistic::fit(&[]), None);
        assert_eq!(Logistic::fit(&[answer(1.0, true), answer(2.0, true)]), None);
        assert_eq!(Logistic::fit(&[answer(1.0, false), answer(2.0, false), answer(3.0, true)]), None);
    }
}
