//! Whatever is logged names what it holds, by size and hash, however large.

use std::collections::BTreeMap;

use super::*;
use crate::geometry::palette::Colors;
use crate::geometry::{Bulk, TriMesh};
use crate::inference::{Edit, MergeProposal, Primitive};
use crate::io::ExportOptions;
use crate::session::selection::Select;
use crate::worker::{
    Command, ExportRequest, LiveResult, Measurement, SeedNews, SeedRequest, SeedRun, Setup, State,
};

const MANY: usize = 20_000;
/// More characters has no line.
const LONGEST: usize = 1000;

fn large() -> State {
    let points: Vec<_> = (0..MANY).map(|i| Point3::new(i as f64, 0.123_456_789, -1e-7)).collect();
    let mesh = TriMesh { vertices: points.clone(), faces: vec![[0, 1, 2]; MANY] };
    let attributes = Attributes {
        colors: Some(vec![[1, 2, 3]; MANY]),
        normals: Some(vec![[0.1, 0.2, 0.3]; MANY]),
        labels: Some((0..MANY as i64).collect()),
    };
    let shape = Arc::new(Shape {
        name: "large.ply".to_owned(),
        path: Some(PathBuf::from("/shapes/large.ply")),
        content: None,
        geometry: ShapeGeometry::Mesh(mesh),
        attributes,
        viewpoints: Vec::new(),
        notes: vec!["3 faces without area were left out".to_owned()],
    });
    let cloud = SampleCloud {
        sample_of_input: Some((0..MANY as u32).collect()),
        ..SampleCloud::from_points(&points)
    };
    let sampling = SamplingOptions::default();
    let loaded = Arc::new(LoadedShape { generation: 1, shape, cloud: Arc::new(cloud), sampling });
    let ids: Vec<u32> = (0..300).collect();
    let occurrences = ids.iter().map(|&id| Occurrence::Born { id, points: 9 }).collect();
    let Event::Snapshot(small) = snapshot(&ids, Phase::Finished, 30, occurrences) else { unreachable!() };
    let mut state = (*small).clone();
    state.abstraction.labels = (0..MANY as u32).collect();
    state.abstraction.pinned = (0..MANY as u32).collect();
    let mut checkpoint = (*state.checkpoint).clone();
    checkpoint.labels = vec![7; MANY];
    state.checkpoint = Arc::new(checkpoint);
    State { loaded, snapshot: Arc::new(state) }
}

/// Each line, unless it is too long.
fn told<T: std::fmt::Debug>(messages: impl IntoIterator<Item = T>) -> Vec<String> {
    let lines: Vec<String> = messages.into_iter().map(|m| format!("{m:?}")).collect();
    for line in &lines {
        assert!(line.len() < LONGEST, "{} characters: {}", line.len(), &line[..LONGEST]);
    }
    lines
}

#[test]
fn messages_from_and_to_the_worker_are_short_however_large_the_shape() {
    let state = large();
    let State { loaded, snapshot } = state.clone();
    let params = Params::default();
    let sampling = SamplingOptions::default();
    let setup = Setup { params, sampling };
    let states = vec![snapshot.clone(); MANY];
    let colors = Arc::new(Colors::new(BTreeMap::new(), 0..MANY as u32));
    let union = Superquadric::sphere(Point3::origin(), 1.0);
    let primitive = Primitive { shape: union, ..snapshot.abstraction.primitives[0].clone() };
    let proposal: MergeProposal = serde_json::from_value(serde_json::json!({
        "pair": [1, 2], "into": 1, "union": union, "revisions": [1, 2], "is_acceptable": true,
        "normalised": { "shape": union, "sum_d2": 1.0, "reason": "" },
        "reason": "the error grows by 3 %", "numbers": [],
    }))
    .unwrap();
    let request = SeedRequest {
        number: 1,
        state: state.clone(),
        colors: colors.clone(),
        params,
        count: 8,
        cancel: Default::default(),
    };
    let samples: Vec<u32> = (0..MANY as u32).collect();
    let commands = [
        Command::Load { source: Source::File("/shapes/large.ply".into()), sampling },
        Command::SetParams(params),
        Command::Renew { setup, at_once: true },
        Command::Resume(state.clone()),
        Command::Edit(Edit::NewCluster { samples: samples.clone() }),
        Command::Edit(Edit::Together { samples: samples.clone() }),
        Command::Edit(Edit::Delete { ids: samples.clone() }),
        Command::Edit(Edit::Take { primitives: vec![primitive.clone(); MANY], labels: samples.clone() }),
        Command::Edit(Edit::AcceptMerge { proposal: Box::new(proposal.clone()) }),
        Command::ProposeMerge { of: None, skipped: vec![(1, 2); MANY].into() },
        Command::Export(Box::new(ExportRequest {
            path: "/shapes/out.ply".into(),
            format: Format::CloudPly,
            options: ExportOptions::default(),
            state: state.clone(),
            colors: colors.clone(),
        })),
        Command::Measure(state.clone()),
        Command::Estimate(vec![state.clone(); 200].into()),
        Command::RunSeeds(Box::new(request)),
    ];
    let lines = told(&commands);
    assert!(lines[3].contains("large.ply") && lines[3].contains("iteration: 30"), "{}", lines[3]);
    assert!(lines[4].contains("20000 #"), "{}", lines[4]);
    told(commands.map(Effect::Send));
    told([Effect::Copy("0.1,".repeat(MANY).into())]);

    let measured = Measurement { snapshot: snapshot.clone(), result: Err("it is not closed".to_owned()) };
    let run = SeedRun { seed: 3, loaded: loaded.clone(), states: states.clone(), colors };
    let lines = told([
        Event::Loaded(loaded.clone()),
        Event::Snapshot(snapshot.clone()),
        Event::LiveStarted(setup),
        Event::LiveFinished(Arc::new(LiveResult { setup, loaded, states })),
        Event::Proposed(Some(Box::new(proposal))),
        Event::Measuring(snapshot),
        Event::Measured(Arc::new(measured)),
        Event::Seeds { request: 1, news: SeedNews::Finished(Arc::new(run)) },
    ]);
    assert!(lines[0].contains("vertices: 20000 #") && lines[0].contains("faces: 20000 #"), "{}", lines[0]);
    assert!(lines[1].contains("labels: 20000 #") && lines[1].contains("primitives: 300 #"), "{}", lines[1]);
}

#[test]
fn actions_and_what_the_session_holds_are_short_as_well() {
    let samples: Vec<u32> = (0..MANY as u32).collect();
    let (ids, how) = (Bulk::from(samples.clone()), Select::Replace);
    told([
        Action::Paste("1,2,3\n".repeat(MANY).into()),
        Action::OpenDropped(vec![PathBuf::from("/shapes/a.obj"); MANY].into()),
        Action::SelectPoints { samples: ids.clone(), how },
        Action::FromList("Select".to_owned(), Box::new(Action::SelectPrimitives { ids, how })),
        Action::Edit(Edit::Release { samples }),
    ]);
    let State { loaded, snapshot: state } = large();
    let mut session = session();
    session.absorb(Event::Loaded(loaded));
    for _ in 0..100 {
        let next = Snapshot { key: Snapshot::new_key(), ..(*state).clone() };
        session.absorb(Event::Snapshot(Arc::new(next)));
        session.apply(Action::Edit(Edit::Delete { ids: vec![3] }));
    }
    let [document] = &told([session.document()])[..] else { unreachable!() };
    assert!(document.contains("large.ply"), "{document}");
    told(session.undo.done().iter());
    told([session.timeline.branches()]);
}
