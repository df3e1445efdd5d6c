!> A geomagnetic field beside that of a model: what the model does not have.
module gracecg_level1_disturbed_field
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: TWO_PI
    use gracecg_base_random, only: random_stream_t
    use gracecg_base_vectors, only: unit
    use gracecg_environment_geomagnetic_field, only: geomagnetic_model_t
    implicit none
    private
    public :: disturb_field

    !> Waves of a component, and the length of each, m: chosen. Some waves for no pattern; so long that the error is one vector
    !> along a span of a minute (460 km), as estimates take it, and another one from span to span
    integer, parameter :: WAVES = 4
    real(dp), parameter :: LENGTH = 8000e3_dp

    !> For each Earth-fixed component waves over some thousand kilometres.
    type, extends(geomagnetic_model_t) :: disturbed_field_t
        class(geomagnetic_model_t), allocatable :: model
        real(dp) :: amplitude = 0                   !! Of a wave, T
        real(dp) :: vector(3, WAVES, 3) = 0         !! Wave vectors, Earth-fixed, rad/m
        real(dp) :: phase(WAVES, 3) = 0             !! rad
    contains
        procedure :: evaluate                       !! Model and waves
    end type disturbed_field_t

contains

    !> Puts waves of random direction and phase on a model, that together have the sigma asked for.
    subroutine disturb_field(sigma, stream, field)
        real(dp), intent(in) :: sigma               !! Of each component, T
        type(random_stream_t), intent(inout) :: stream
        class(geomagnetic_model_t), allocatable, intent(inout) :: field

        type(disturbed_field_t), allocatable :: disturbed
        integer :: axis, wave

        allocate (disturbed)
        disturbed%amplitude = sigma*sqrt(2.0_dp/WAVES)
        do axis = 1, 3
            do wave = 1, WAVES
                call stream%normals(disturbed%vector(:, wave, axis))
                disturbed%vector(:, wave, axis) = TWO_PI/LENGTH*unit(disturbed%vector(:, wave, axis))
                disturbed%phase(wave, axis) = TWO_PI*stream%uniform()
            end do
        end do
        call move_alloc(field, disturbed%model)
        call move_alloc(disturbed, field)
    end subroutine disturb_field

    pure subroutine evaluate(self, position, b)
        class(disturbed_field_t), intent(in) :: self
        real(dp), intent(in) :: position(3)     !! Earth-fixed, m
        real(dp), intent(out) :: b(3)           !! Earth-fixed, T

        integer :: axis

        call self%model%evaluate(position, b)
        do axis = 1, 3
            b(axis) = b(axis) + self%amplitude*sum(cos(matmul(position, self%vector(:, :, axis)) + self%phase(:, axis)))
        end do
    end subroutine evaluate
end module gracecg_level1_disturbed_field
