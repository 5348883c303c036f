//! Starts the viewer in a page of a browser.
//!
//! The page has a canvas named `lobe`, and beside it the file `still-life.glb`: the built-in scene, baked, because a page with
//! one thread would bake it for minutes. Without the file the scene is lit without shadows.

use std::sync::Arc;

use eframe::egui_wgpu::WgpuSetup;
use eframe::{WebOptions, WebRunner, wgpu};
use js_sys::Uint8Array;
use wasm_bindgen::{JsCast as _, JsValue};
use wasm_bindgen_futures::{JsFuture, spawn_local};
use web_sys::{HtmlCanvasElement, Response};

use crate::app::viewer_app::ViewerApp;
use crate::loading::cache::UserFolder;
use crate::loading::place::give_file;
use crate::widgets::gpu::Gpu;

/// The canvas.
const CANVAS: &str = "lobe";

/// The scene beside the page.
const SCENE: &str = "still-life.glb";

/// Starts the viewer; what goes wrong is thrown, and so on the console of the page.
pub(crate) fn open() {
    spawn_local(async {
        if let Err(error) = run().await {
            wasm_bindgen::throw_val(error);
        }
    });
}

async fn run() -> Result<(), JsValue> {
    let document = web_sys::window().and_then(|window| window.document());
    let canvas = document.and_then(|document| document.get_element_by_id(CANVAS));
    let canvas: HtmlCanvasElement = canvas.ok_or("this page has no canvas named lobe")?.dyn_into()?;
    let scene = fetched(SCENE).await;
    let files = if let Ok(bytes) = scene {
        give_file(SCENE, bytes);
        vec![SCENE.into()]
    } else {
        Vec::new()
    };
    let create = Box::new(move |creation: &eframe::CreationContext<'_>| {
        let gpu = creation.wgpu_render_state.as_ref().map(Gpu::of_window);
        let app: Box<dyn eframe::App> = Box::new(ViewerApp::new(gpu, UserFolder::none(), &files));
        Ok(app)
    });
    WebRunner::new().start(canvas, options(), create).await
}

/// WebGL 2, with the limits of the adapter: textures of transfer are large.
fn options() -> WebOptions {
    let mut options = WebOptions::default();
    if let WgpuSetup::CreateNew(setup) = &mut options.wgpu_options.wgpu_setup {
        setup.instance_descriptor.backends = wgpu::Backends::GL;
        setup.device_descriptor = Arc::new(|adapter| wgpu::DeviceDescriptor {
            label: Some("lobe-viewer"),
            required_limits: adapter.limits(),
            ..wgpu::DeviceDescriptor::default()
        });
    }
    options
}

/// The bytes of a file beside the page.
async fn fetched(name: &str) -> Result<Vec<u8>, JsValue> {
    let window = web_sys::window().ok_or("no window")?;
    let response: Response = JsFuture::from(window.fetch_with_str(name)).await?.dyn_into()?;
    if !response.ok() {
        return Err(response.status_text().into());
    }
    Ok(Uint8Array::new(&JsFuture::from(response.array_buffer()?).await?).to_vec())
}
