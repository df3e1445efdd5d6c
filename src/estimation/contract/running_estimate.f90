!> The offset as a filter estimates it on the way.
module gracecg_estimation_running_estimate
    use gracecg_base_kinds, only: dp
    implicit none
    private
    public :: running_estimate_t

    !> The estimate as it stood at every epoch, from the samples until then.
    type :: running_estimate_t
        real(dp), allocatable :: time(:)                    !! (epochs), s
        real(dp), allocatable :: offset(:, :)               !! (3, epochs), m
        real(dp), allocatable :: sigma(:, :)                !! (3, epochs), m
        integer, allocatable :: edited_accelerometer(:)     !! (epochs), values edited until then
        integer, allocatable :: edited_star_camera(:)       !! (epochs), samples edited until then
    end type running_estimate_t
end module gracecg_estimation_running_estimate
