"""Lobe's rule for shading normals, as a material of Mitsuba: `path` traces by it what Lobe traces.

Mitsuba's `twosided` turns the shading normal to the viewer, and lets rays below a triangle go on into the solid. Lobe
turns both normals to the side of the triangle that is seen, and reflects nothing from below it. The two are the same
where shading normals are those of triangles.
"""

import drjit as dr
import mitsuba as mi


def lobe_matte(color):
    """The material of a color, once it is registered."""
    return {"type": "lobe_matte", "reflectance": {"type": "rgb", "value": list(color)}}


def register():
    """Adds the material `lobe_matte` to the variant that is set; its `reflectance` is one color."""

    class LobeMatte(mi.BSDF):
        def __init__(self, properties):
            super().__init__(properties)
            self.reflectance = mi.Color3f(properties["reflectance"])
            self.m_flags = mi.BSDFFlags.DiffuseReflection | mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide
            self.m_components = [self.m_flags]

        def sample(self, ctx, si, sample1, sample2, active):
            local = mi.warp.square_to_cosine_hemisphere(sample2)
            drawn = dr.zeros(mi.BSDFSample3f)
            drawn.wo = mi.Vector3f(local.x, local.y, side_of(si, si.wi) * local.z)
            drawn.pdf = mi.warp.square_to_cosine_hemisphere_pdf(local)
            drawn.eta, drawn.sampled_type, drawn.sampled_component = 1.0, mi.UInt32(+self.m_flags), 0
            is_above = side_of(si, drawn.wo) == side_of(si, si.wi)
            return drawn, dr.select(active & is_above & (drawn.pdf > 0), self.reflectance, 0)

        def eval_pdf(self, ctx, si, wo, active):
            cosine = wo.z * side_of(si, si.wi)
            is_drawn = active & (cosine > 0)
            is_above = side_of(si, wo) == side_of(si, si.wi)
            density = dr.select(is_drawn, cosine * dr.inv_pi, 0)
            return dr.select(is_above, self.reflectance * density, 0), density

        def eval(self, ctx, si, wo, active):
            return self.eval_pdf(ctx, si, wo, active)[0]

        def pdf(self, ctx, si, wo, active):
            return self.eval_pdf(ctx, si, wo, active)[1]

        def to_string(self):
            return "LobeMatte[]"

    mi.register_bsdf("lobe_matte", LobeMatte)


def side_of(si, local):
    """The side of the triangle that a direction in the frame of the shading normal is on: 1 or -1."""
    return dr.select(dr.dot(si.n, si.to_world(local)) > 0, mi.Float(1), mi.Float(-1))
