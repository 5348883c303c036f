// uses: elementary
// Windows: factors of bands that exchange ringing for blur, as `lobe_sh::Window::factor`, after Sloan 2008. l is the
// number of the band; the factor of band 0 is 1.

// The Hanning window's factor of band l: (1 + cos(pi l/w))/2, 0 from the width w > 0 on.
fn hanning_window(l: f32, width: f32) -> f32 {
    // cos^2(x/2) with x = pi l/w, by the sine of x/4.
    let quarter = sin_cos_eighth(0.785398163397448 * min(l / width, 1.0));
    let cosine = 1.0 - 2.0 * quarter.x * quarter.x;
    return select(cosine * cosine, 0.0, l >= width && l > 0.0);
}

// The Lanczos window's factor of band l: (sin(pi l/w)/(pi l/w))^p, 0 from the width w > 0 on.
fn lanczos_window(l: f32, width: f32, power: f32) -> f32 {
    let x = 3.14159265358979 * min(l / width, 1.0);
    if x == 0.0 {
        return 1.0;
    }
    // sin x = 4 sin(x/4) cos(x/4) cos(x/2)
    let quarter = sin_cos_eighth(0.25 * x);
    let sine = 4.0 * quarter.x * quarter.y * (1.0 - 2.0 * quarter.x * quarter.x);
    return select(pow(max(sine, 0.0) / x, power), 0.0, l >= width);
}

// The Gauss window's factor of band l: exp(-sigma^2 l(l+1)/2), sigma in radians.
fn gauss_window(l: f32, sigma: f32) -> f32 {
    return exp(-0.5 * sigma * sigma * l * (l + 1.0));
}

// The squared Laplacian window's factor of band l: 1/(1 + lambda l^2 (l+1)^2).
fn squared_laplacian_window(l: f32, lambda: f32) -> f32 {
    let eigenvalue = l * (l + 1.0);
    return 1.0 / (1.0 + lambda * eigenvalue * eigenvalue);
}
