//! Shapes in double precision: the primitive, clouds and meshes. Depends on
//! nothing else of this crate.

pub(crate) mod brief;
pub mod cloud;
mod elimination;
mod forest;
mod frame;
pub mod hull;
mod isolated;
pub mod kernel;
pub mod mass;
pub mod mesh;
pub mod metrics;
mod morton;
pub mod neighbors;
pub mod outside;
pub mod palette;
pub mod sampling;
pub mod segmentation;
pub mod superquadric;
pub mod tessellate;
pub mod theta;

pub use brief::Bulk;
pub use cloud::{NO_SAMPLE, SampleCloud, SampledPart};
pub use mass::MassProperties;
pub use mesh::TriMesh;
#[cfg(feature = "window")]
pub(crate) use morton::short_code;
pub use sampling::{
    Isolated, SamplingError, SamplingOptions, Surface, sample_cloud, sample_mesh, scatter_mesh,
};
pub use theta::Superquadric;
