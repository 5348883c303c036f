//! Shading by precomputed radiance transfer: the exit radiance of receivers, interpolated at the points between them.

use lobe_env::DfgTable;
use lobe_io::{Job, parallel};
use lobe_prt::{
    AnyTransfer, BakeOptions, BakeReport, FittedVertices, GlossyLobe, Lightmap, PrtError, Receivers, TransferMatrices,
    bake, bake_matrices,
};
use lobe_scene::{Bvh, Scene};
use lobe_sh::{Coefficient as _, Expansion as _, Rgb, ShVec};

use crate::scene_view::scene_picture::SceneHit;

/// The part of uniform light that a glossy surface reflects towards the eye.
enum DirectionalAlbedo {
    /// The base color.
    Base,
    /// That of microfacets.
    Microfacets { table: DfgTable, roughness: f64 },
}

impl DirectionalAlbedo {
    fn of(lobe: GlossyLobe) -> Self {
        match lobe {
            GlossyLobe::Phong(_) => Self::Base,
            GlossyLobe::Ggx(alpha) => Self::Microfacets { table: DfgTable::default(), roughness: alpha.sqrt() },
        }
    }

    fn at(&self, hit: &SceneHit<'_>) -> Rgb<f64> {
        match self {
            Self::Base => hit.albedo,
            Self::Microfacets { table, roughness } => {
                table.lookup(hit.normal.dot(hit.view).max(0.0), *roughness).reflectance(hit.albedo)
            }
        }
    }
}

/// A lobe with its directional albedo.
pub(crate) struct Gloss {
    lobe: GlossyLobe,
    albedo: DirectionalAlbedo,
}

impl Gloss {
    pub(crate) fn new(lobe: GlossyLobe) -> Self {
        Self { lobe, albedo: DirectionalAlbedo::of(lobe) }
    }

    /// The directional albedo: the factor of the blurred light in the mirrored direction.
    pub(crate) fn albedo(&self, hit: &SceneHit<'_>) -> Rgb<f64> {
        self.albedo.at(hit)
    }
}

/// The places of a scene where transfer is known.
pub(crate) enum Places {
    Vertices,
    Texels(Box<Lightmap>),
}

impl Places {
    pub(crate) fn count(&self, scene: &Scene) -> usize {
        match self {
            Self::Vertices => scene.vertex_count(),
            Self::Texels(lightmap) => lightmap.width().pow(2),
        }
    }

    /// The places around a hit and their weights, which sum to 1.
    pub(crate) fn around(&self, scene: &Scene, hit: &SceneHit<'_>) -> [(usize, f64); 4] {
        match self {
            Self::Vertices => {
                let [a, b, c] = hit.corners();
                [a, b, c, (a.0, 0.0)]
            }
            Self::Texels(lightmap) => lightmap.texels_at(scene, hit.hit()),
        }
    }
}

/// The transfer of all receivers, diffuse or glossy.
pub(crate) enum SurfaceTransfer {
    /// Transfer vectors: exit radiance, the same for every view.
    Matte(AnyTransfer),
    /// Transfer matrices: the light that arrives, to be reflected by a lobe.
    Glossy(TransferMatrices),
}

impl SurfaceTransfer {
    pub(crate) fn bake(
        scene: &Scene,
        bvh: &Bvh,
        receivers: &Receivers,
        options: &BakeOptions,
        is_glossy: bool,
        job: Job<'_>,
    ) -> Result<(Self, BakeReport), PrtError> {
        if is_glossy {
            let (matrices, report) = bake_matrices(scene, bvh, receivers, options, job)?;
            Ok((Self::Glossy(matrices), report))
        } else {
            let (transfer, report) = bake(scene, bvh, receivers, options, job)?;
            Ok((Self::Matte(transfer.into()), report))
        }
    }

    /// Transfer of vertices, fitted.
    pub(crate) fn fit(
        vertices: &FittedVertices<'_>,
        bvh: &Bvh,
        options: &BakeOptions,
        is_glossy: bool,
        job: Job<'_>,
    ) -> Result<(Self, BakeReport), PrtError> {
        if is_glossy {
            let (matrices, report) = vertices.bake_matrices(bvh, options, job)?;
            Ok((Self::Glossy(matrices), report))
        } else {
            let (transfer, report) = vertices.bake(bvh, options, job)?;
            Ok((Self::Matte(transfer.into()), report))
        }
    }

    pub(crate) fn order(&self) -> usize {
        match self {
            Self::Matte(transfer) => transfer.order(),
            Self::Glossy(matrices) => matrices.order(),
        }
    }

    /// Applies the transfer of all receivers to one light. Matrices need the lobe.
    pub(crate) fn lit(&self, light: &ShVec<Rgb<f64>>, gloss: Option<&Gloss>) -> LitReceivers {
        match (self, gloss) {
            (Self::Matte(transfer), _) => LitReceivers::Matte(transfer.exit_radiance(light.coefficients())),
            (Self::Glossy(matrices), Some(gloss)) => {
                let zonal = gloss.lobe.zonal(matrices.order());
                let bands = matrices.order().pow(2);
                let mut incident = vec![Rgb::new(0.0, 0.0, 0.0); matrices.points() * bands];
                matrices.incident_into(light.coefficients(), &mut incident);
                let wide = |f: &[Rgb<f32>]| ShVec::from_vec(f.iter().map(|c| c.widen()).collect());
                let blurred = |receiver: usize| {
                    let f = wide(&incident[receiver * bands..][..bands]);
                    f.unwrap_or_else(|| unreachable!("n² coefficients")).convolved(&zonal)
                };
                LitReceivers::Glossy(parallel::map(matrices.points(), &blurred))
            }
            (Self::Glossy(_), None) => unreachable!("matrices come with a lobe"),
        }
    }
}

/// Receivers under one light.
pub(crate) enum LitReceivers {
    /// The exit radiance of each.
    Matte(Vec<Rgb<f32>>),
    /// The light that arrives at each, convolved with the lobe: its value in the mirrored direction is reflected.
    Glossy(Vec<ShVec<Rgb<f64>>>),
}

impl LitReceivers {
    /// Takes away the values of the same receivers; matte ones alone.
    pub(crate) fn subtract_each(&mut self, part: &Self) {
        if let (Self::Matte(all), Self::Matte(part)) = (self, part) {
            all.iter_mut().zip(part).for_each(|(all, part)| *all -= *part);
        }
    }

    /// The values of matte receivers.
    pub(crate) fn into_matte(self) -> Option<Vec<Rgb<f32>>> {
        match self {
            Self::Matte(values) => Some(values),
            Self::Glossy(_) => None,
        }
    }

    pub(crate) fn radiance(&self, receiver: usize, hit: &SceneHit<'_>) -> Rgb<f64> {
        match self {
            Self::Matte(values) => values[receiver].widen(),
            Self::Glossy(blurred) => blurred[receiver].eval(hit.reflected()),
        }
    }
}
