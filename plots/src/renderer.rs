//! Specifications as SVG.
//!
//! The vendored libraries run in an embedded JavaScript engine without files, network, clock or
//! random numbers, so that equal specifications give equal bytes.

use rquickjs::{CatchResultExt as _, Context, Ctx, Function, Object, Runtime};
use serde_json::Value;

use crate::library::LIBRARIES;
use crate::look::{Ink, dressed};

/// Bytes of stack: the compiler of specifications is recursive.
const STACK: usize = 1 << 20;

/// A plot that cannot be drawn.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("the plotting library: {0}")]
pub struct PlotError(String);

/// The libraries, loaded once for several plots.
pub struct Renderer {
    runtime: Runtime,
    context: Context,
}

impl Renderer {
    /// Loads the libraries.
    ///
    /// # Errors
    /// The engine has no memory.
    pub fn new() -> Result<Self, PlotError> {
        let no_engine = |error: rquickjs::Error| PlotError(error.to_string());
        let runtime = Runtime::new().map_err(no_engine)?;
        runtime.set_max_stack_size(STACK);
        let context = Context::full(&runtime).map_err(no_engine)?;
        context.with(|ctx| {
            run(&ctx, include_str!("shims.js"))?;
            LIBRARIES.iter().try_for_each(|own| run(&ctx, own.text))
        })?;
        Ok(Self { runtime, context })
    }

    /// Draws a specification.
    ///
    /// # Errors
    /// A specification that the library refuses or warns of.
    pub fn svg(&self, spec: &Value, ink: Ink) -> Result<String, PlotError> {
        self.dressed_svg(&dressed(spec, ink))
    }

    /// Draws a specification as it is, without the common look.
    ///
    /// # Errors
    /// As [`Renderer::svg`].
    pub fn dressed_svg(&self, spec: &Value) -> Result<String, PlotError> {
        let text = spec.to_string();
        self.context.with(|ctx| {
            let draw: Function<'_> = caught(&ctx, ctx.globals().get("draw"))?;
            caught(&ctx, draw.call::<_, ()>((text,)))
        })?;
        while self.runtime.is_job_pending() {
            self.runtime
                .execute_pending_job()
                .map_err(|error| PlotError(error.to_string()))?;
        }
        self.context.with(|ctx| {
            let drawn: Object<'_> = caught(&ctx, ctx.globals().get("drawn"))?;
            let svg: Option<String> = caught(&ctx, drawn.get("svg"))?;
            let error: Option<String> = caught(&ctx, drawn.get("error"))?;
            svg.ok_or_else(|| PlotError(error.unwrap_or_else(|| "no picture".to_owned())))
        })
    }
}

fn run(ctx: &Ctx<'_>, text: &str) -> Result<(), PlotError> {
    caught(ctx, ctx.eval::<(), _>(text))
}

/// A result, with the exception's words where one was thrown.
fn caught<'js, T>(ctx: &Ctx<'js>, result: rquickjs::Result<T>) -> Result<T, PlotError> {
    result
        .catch(ctx)
        .map_err(|error| PlotError(error.to_string()))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use serde_json::json;

    use super::*;

    fn bars() -> Value {
        json!({
            "data": { "values": [{ "of": "one", "ms": 27.5 }, { "of": "two", "ms": 55 }] },
            "mark": "bar",
            "encoding": {
                "x": { "field": "ms", "type": "quantitative", "title": "ms a frame" },
                "y": { "field": "of", "type": "nominal" },
            },
        })
    }

    #[test]
    fn a_bar_is_as_long_as_its_value() {
        let svg = Renderer::new().unwrap().svg(&bars(), Ink::File).unwrap();
        assert!(svg.starts_with("<svg") && svg.ends_with("</svg>"), "{svg}");
        assert!(svg.contains("ms a frame"), "{svg}");
        // The axis ends at 55, at 300 pixels.
        assert!(svg.contains("h150v") && svg.contains("h300v"), "{svg}");
    }

    #[test]
    fn equal_specifications_give_equal_bytes() {
        let renderer = Renderer::new().unwrap();
        let of = |renderer: &Renderer| renderer.svg(&bars(), Ink::Page).unwrap();
        let [first, again] = [of(&renderer), of(&renderer)];
        assert_eq!(first, again);
        assert_eq!(first, of(&Renderer::new().unwrap()));
    }

    #[test]
    fn what_the_library_warns_of_is_an_error() {
        let renderer = Renderer::new().unwrap();
        let mut spec = bars();
        spec["encoding"]["nonsense"] = json!({ "field": "ms" });
        let error = renderer.svg(&spec, Ink::File).unwrap_err().to_string();
        assert!(error.contains("nonsense"), "{error}");
        spec = json!({ "mark": 3 });
        assert!(renderer.svg(&spec, Ink::File).is_err());
        assert!(renderer.svg(&bars(), Ink::File).is_ok());
    }
}
