// The lookups for the cubes of this folder, as the glTF sample viewer has them; written by lobe {{version}}.
// Directions are those of glTF: y up, right-handed.
uniform samplerCube diffuseCube;  // diffuse.ktx2: irradiance over pi
uniform samplerCube specularCube; // specular.ktx2: level r (levels - 1) holds roughness r

// What a white matte surface with normal n sends back.
vec3 diffuseLight(vec3 n) {
    return texture(diffuseCube, n).rgb;
}

// The light that a surface of this roughness mirrors towards the reflected view; multiply it by F0 A + B.
vec3 specularLight(vec3 reflected, float roughness, float levels) {
    return textureLod(specularCube, reflected, roughness * (levels - 1.0)).rgb;
}
