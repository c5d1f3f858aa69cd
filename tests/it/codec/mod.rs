mod damage;
mod errors;
mod witnesses;
