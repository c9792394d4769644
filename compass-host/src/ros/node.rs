//! The node: topics in, topics out.

use super::error::{NodeError, failed};
use super::messages::{CompressedImage, Image, Odometry, TriggerRequest, TriggerResponse};
use super::options::Options;
use super::outputs::outputs;
use super::pairing::Pairing;
use super::worker::{Job, Picture, Slot, Worker};
use crate::calibration::Calibration;
use crate::site_file::SiteFloor;
use ros2_client::dds::rustdds::mio1::{Events, Interest, Poll, Token};
use ros2_client::qos::History;
use ros2_client::{
    Context, ContextOptions, Message, MessageTypeName, Name, Node, NodeName, NodeOptions, QosProfile, Server,
    ServiceMapping, ServiceTypeName, Subscription,
};
use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// How often the node looks whether it shall end.
const TICK: Duration = Duration::from_millis(100);
/// After this long without a frame, and again, the topics are looked at.
const SILENCE: Duration = Duration::from_secs(5);
/// Odometry that is remembered.
const ODOMETRY: usize = 256;

impl Message for TriggerRequest {}
impl Message for TriggerResponse {}

/// A camera's topic, of either type.
enum Camera {
    Raw(Subscription<Image>),
    Compressed(Subscription<CompressedImage>),
}

impl Camera {
    /// The next message, if there is one; what cannot be decoded is said.
    fn take(&self, say: &dyn Fn(&str)) -> Option<Picture> {
        let taken = match self {
            Self::Raw(topic) => topic.take().map(|taken| taken.map(|(image, _)| Picture::Raw(image))),
            Self::Compressed(topic) => {
                topic.take().map(|taken| taken.map(|(image, _)| Picture::Compressed(image)))
            }
        };
        taken.unwrap_or_else(|error| {
            say(&format!("a frame cannot be decoded: {error:?}"));
            None
        })
    }
}

/// The type of an image topic, by its name.
fn type_of(topic: &str) -> &'static str {
    if topic.ends_with("/compressed") { "CompressedImage" } else { "Image" }
}

/// Runs the node until `stop`. `say` is told what a person should know, a line at a time.
///
/// # Errors
/// [`NodeError`] names the topic or name that cannot be used.
pub fn run(
    options: &Options,
    floors: &[SiteFloor<'_>],
    calibration: &Calibration,
    stop: &AtomicBool,
    say: &dyn Fn(&str),
) -> Result<(), NodeError> {
    let context = ContextOptions::new().domain_id(options.domain);
    let context = Context::with_options(context)
        .map_err(|error| failed(format!("domain {}", options.domain), format!("{error:?}")))?;
    let name = NodeName::new(&options.namespace, &options.name).map_err(|error| {
        failed(format!("node name {}/{}", options.namespace, options.name), format!("{error:?}"))
    })?;
    let mut node = context
        .new_node(name, NodeOptions::new().enable_rosout(false))
        .map_err(|error| failed(options.name.as_str(), format!("{error:?}")))?;
    let mut inputs = Inputs::new(&mut node, options)?;
    let outputs = outputs(&mut node)?;
    let slot = Slot::default();
    std::thread::scope(|scope| {
        let worker = Worker::new(options, floors, calibration, &outputs);
        let working = scope.spawn(|| worker.run(&slot));
        let heard = inputs.hear(options, &slot, stop, say, &|| working.is_finished());
        slot.end();
        let ended = working.join();
        heard.and(ended.map_err(|_| failed("the localization", "it ended by a defect of its own")))
    })
}

fn subscription<M: 'static>(
    node: &mut Node,
    name: &str,
    kind: (&str, &str),
) -> Result<Subscription<M>, NodeError> {
    let sensor_data = QosProfile::subscription_default().history(History::KeepLast { depth: 5 });
    let parsed = Name::parse(name).map_err(|error| failed(name, format!("no name of a topic: {error:?}")))?;
    let topic = node
        .create_topic(&parsed, MessageTypeName::new(kind.0, kind.1), &sensor_data)
        .map_err(|error| failed(name, format!("{error:?}")))?;
    node.create_subscription(&topic, None).map_err(|error| failed(name, format!("{error:?}")))
}

/// What the node listens to.
struct Inputs {
    cameras: [Option<Camera>; 2],
    odometry: Option<Subscription<Odometry>>,
    service: Server<TriggerRequest, TriggerResponse>,
    poll: Poll,
    pairing: Pairing<Picture>,
    way: VecDeque<Odometry>,
}

impl Inputs {
    fn new(node: &mut Node, options: &Options) -> Result<Self, NodeError> {
        let mut camera = |topic: &String| match type_of(topic) {
            "CompressedImage" => {
                subscription(node, topic, ("sensor_msgs", "CompressedImage")).map(Camera::Compressed)
            }
            _ => subscription(node, topic, ("sensor_msgs", "Image")).map(Camera::Raw),
        };
        let [first, second] = &options.topics;
        let mut cameras =
            [first.as_ref().map(&mut camera).transpose()?, second.as_ref().map(&mut camera).transpose()?];
        let odometry =
            options.odometry.as_ref().map(|topic| subscription(node, topic, ("nav_msgs", "Odometry")));
        let mut odometry = odometry.transpose()?;
        let reliable = QosProfile::publisher_default().history(History::KeepLast { depth: 10 });
        let own = format!("{}/relocalize", node.fully_qualified_name());
        let own_name = Name::parse(&own).map_err(|error| failed(own.as_str(), format!("{error:?}")))?;
        let kind = ServiceTypeName::new("std_srvs", "Trigger");
        let mut service = node
            .create_server(ServiceMapping::Enhanced, &own_name, &kind, reliable.clone(), reliable)
            .map_err(|error| failed(own.as_str(), format!("{error:?}")))?;
        let poll = Poll::new().map_err(|error| failed("waiting for messages", error.to_string()))?;
        let registry = poll.registry();
        let mut registered = Ok(());
        for (number, camera) in cameras.iter_mut().enumerate() {
            registered = registered.and(match camera {
                Some(Camera::Raw(topic)) => registry.register(topic, Token(number), Interest::READABLE),
                Some(Camera::Compressed(topic)) => {
                    registry.register(topic, Token(number), Interest::READABLE)
                }
                None => Ok(()),
            });
        }
        if let Some(odometry) = &mut odometry {
            registered = registered.and(registry.register(odometry, Token(2), Interest::READABLE));
        }
        registered = registered.and(registry.register(&mut service, Token(3), Interest::READABLE));
        registered.map_err(|error| failed("waiting for messages", error.to_string()))?;
        let pairing = Pairing::new(options.topics.each_ref().map(Option::is_some), options.pair_within_ns);
        Ok(Self { cameras, odometry, service, poll, pairing, way: VecDeque::new() })
    }

    /// Hands what comes to the worker, until the end.
    fn hear(
        &mut self,
        options: &Options,
        slot: &Slot,
        stop: &AtomicBool,
        say: &dyn Fn(&str),
        is_over: &dyn Fn() -> bool,
    ) -> Result<(), NodeError> {
        let mut events = Events::with_capacity(16);
        let mut last = Instant::now();
        while !stop.load(Ordering::Relaxed) && !is_over() {
            match self.poll.poll(&mut events, Some(TICK)) {
                Err(error) if error.kind() != std::io::ErrorKind::Interrupted => {
                    return Err(failed("waiting for messages", error.to_string()));
                }
                _ => {}
            }
            // All are looked at, whichever woke us: a notification covers any number of messages.
            self.take_odometry();
            if self.take_frames(slot, say) {
                last = Instant::now();
            }
            self.take_requests(slot);
            if last.elapsed() > SILENCE {
                last = Instant::now();
                say(&silence(options));
            }
        }
        Ok(())
    }

    fn take_odometry(&mut self) {
        let Some(topic) = &self.odometry else { return };
        while let Ok(Some((message, _))) = topic.take() {
            if self.way.len() == ODOMETRY {
                self.way.pop_front();
            }
            self.way.push_back(message);
        }
    }

    /// Whether any frame came.
    fn take_frames(&mut self, slot: &Slot, say: &dyn Fn(&str)) -> bool {
        let mut any = false;
        for number in 0..2 {
            while let Some(picture) = self.cameras[number].as_ref().and_then(|camera| camera.take(say)) {
                any = true;
                let stamp = picture.stamp();
                let Some(nanoseconds) = stamp.nanoseconds() else {
                    say(&format!(
                        "a frame of cam{number} is left out: its stamp {}.{:09} is none",
                        stamp.sec, stamp.nanosec
                    ));
                    continue;
                };
                let Some((stamp_ns, pictures)) = self.pairing.take(number, nanoseconds, picture) else {
                    continue;
                };
                let stamp = pictures.iter().flatten().next().map_or(stamp, Picture::stamp);
                let odometry = self.nearest(stamp_ns).cloned();
                slot.put(Job { stamp_ns, stamp, pictures, odometry, arrived: Instant::now() });
            }
        }
        any
    }

    fn nearest(&self, stamp_ns: u64) -> Option<&Odometry> {
        let gap = |message: &&Odometry| {
            message.header.stamp.nanoseconds().map_or(u64::MAX, |at| at.abs_diff(stamp_ns))
        };
        self.way.iter().min_by_key(gap)
    }

    fn take_requests(&mut self, slot: &Slot) {
        while let Ok(Some((id, _))) = self.service.receive_request() {
            slot.relocalize();
            let message = "the next sure pose is said anew".to_owned();
            let _ = self.service.send_response(id, TriggerResponse { success: true, message });
        }
    }
}

/// What is waited for, and how to find out why it does not come: a message of another type is none to DDS.
fn silence(options: &Options) -> String {
    let topics = options.topics.iter().flatten();
    let topics: Vec<_> =
        topics.map(|topic| format!("{topic} (sensor_msgs/msg/{})", type_of(topic))).collect();
    format!(
        "no frames on {}: does anybody publish there, and this type? ros2 topic info -v tells",
        topics.join(" and ")
    )
}
