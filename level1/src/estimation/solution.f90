!> An offset by Level-1 data, and what it rests on.
module gracecg_level1_solution
    use gracecg_base_kinds, only: dp
    use gracecg_estimation_belief_report, only: belief_report_t
    implicit none
    private
    public :: level1_solution_t, sigma_of

    type :: level1_solution_t
        !! An offset with what it rests on
        character(12) :: source = ''                    !! Of LEVEL1_SOURCES
        character(12) :: leakage = ''                   !! estimated or a priori
        logical :: separable = .false.                  !! Whether the samples tell leakage from d
        real(dp) :: offset(3) = 0                       !! d, m, SRF
        real(dp) :: covariance(3, 3) = 0                !! m^2
        real(dp) :: leak(3, 3) = 0, leak_sigma(3, 3) = 0            !! L: axis, rod; m/s^2/mA
        real(dp) :: leak_rate(3, 3) = 0, leak_rate_sigma(3, 3) = 0  !! K, m/s^2/(mA/s)
        real(dp) :: sigma_alone(3) = 0                  !! Of d if no leakage is estimated, m
        real(dp) :: sigma_free(3) = 0                   !! If it is estimated without a-priori sigma, m; huge: cannot be
        real(dp) :: condition = 0                       !! Of the scaled normal matrix with leakage, without a-priori sigma
        character(160) :: weakest = ''                  !! Direction that the data determine least
        real(dp) :: rms(3) = 0                          !! Of the accelerometer's noise, m/s^2
        integer :: samples = 0, spans = 0    !! That are used
        real(dp), allocatable :: span_offset(:, :)      !! By each span alone with the leakage of all, m
        real(dp), allocatable :: span_covariance(:, :, :)   !! (3, 3, spans), m^2; 0: not determined
        real(dp), allocatable :: span_rms(:, :)         !! Likewise, of each span
        real(dp) :: chi_square = 0                      !! Of the spans about the combined offset
        integer :: degrees = 0                          !! Of freedom of it
        type(belief_report_t), allocatable :: beliefs   !! What the samples say of the setup; of the first alone
        integer :: flag = 2                             !! 0 good, 1 with care, 2 not to be used
        character(200) :: reason = ''                   !! Why not 0
    end type level1_solution_t

contains

    !> Standard deviations of the offset.
    pure function sigma_of(solution, span) result(sigma)
        type(level1_solution_t), intent(in) :: solution
        integer, intent(in), optional :: span   !! By that alone; 0: it does not determine it. Absent: of all
        real(dp) :: sigma(3)                    !! m

        integer :: k

        if (present(span)) then
            sigma = sqrt([(solution%span_covariance(k, k, span), k=1, 3)])
        else
            sigma = sqrt([(solution%covariance(k, k), k=1, 3)])
        end if
    end function sigma_of
end module gracecg_level1_solution
