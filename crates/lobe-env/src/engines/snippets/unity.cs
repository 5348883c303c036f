// The light of a sky for Unity, written by lobe {{version}}. README.md says what the folder holds. By the formulas of
// Unity's source: this script was not run.
//
// Copy the folder into Assets. Import both pictures as cubes (Texture Shape: Cube, Mapping: Latitude-Longitude),
// light.hdr with Convolution Type: Specular. Make a material of Skybox/Cubemap with sky.hdr; Skybox/Panoramic would
// turn it by a quarter. Put this component into the scene, and give it the cube of light.hdr and the material.
using UnityEngine;
using UnityEngine.Rendering;

[ExecuteAlways]
public class LobeSky : MonoBehaviour
{
    public Cubemap reflection;
    public Material skybox;

    // What a white surface sends back, nine numbers for red, then for green, then for blue.
    static readonly float[] Coefficients =
    {
    {{coefficients:f}}
    };

    // Suns: the direction towards each, the irradiance of a surface that faces it, the diameter of its disc in degrees.
    static readonly float[][] Suns = new float[][]
    {
    {{suns:csharp}}
    };

    void OnEnable()
    {
        var probe = new SphericalHarmonicsL2();
        for (int channel = 0; channel < 3; channel++)
            for (int i = 0; i < 9; i++)
                probe[channel, i] = Coefficients[9 * channel + i];
        RenderSettings.ambientMode = AmbientMode.Custom;
        RenderSettings.ambientProbe = probe;
        if (skybox != null) RenderSettings.skybox = skybox;
        if (reflection != null)
        {
            RenderSettings.defaultReflectionMode = DefaultReflectionMode.Custom;
            RenderSettings.customReflectionTexture = reflection;
        }
        foreach (var sun in Suns) AddSun(sun);
    }

    void OnDisable()
    {
        foreach (var light in GetComponentsInChildren<Light>())
            if (light.name == "sun") DestroyImmediate(light.gameObject);
    }

    void AddSun(float[] sun)
    {
        var holder = new GameObject("sun") { hideFlags = HideFlags.DontSave };
        holder.transform.SetParent(transform, false);
        holder.transform.rotation = Quaternion.LookRotation(-new Vector3(sun[0], sun[1], sun[2]));
        var light = holder.AddComponent<Light>();
        float brightest = Mathf.Max(sun[3], Mathf.Max(sun[4], sun[5]));
        light.type = LightType.Directional;
        // Colors of lights are those of displays; a light of intensity 1 makes a white surface that faces it 1.
        light.color = new Color(sun[3] / brightest, sun[4] / brightest, sun[5] / brightest).gamma;
        light.intensity = brightest / Mathf.PI;
    }
}
